# SPDX-License-Identifier: Apache-2.0
"""The robot starts when every marked cell was touched, asked for by the command or by the page."""

import re
import subprocess
import time
from pathlib import Path

import numpy as np
import pytest
from staged import HOST, ROBOT, PatientGains, Stage, command, held_units, soon

from robotskin.connecting import ConnectedRobot, ConnectError, TouchOrder, marked_cells
from robotskin.live.connected_session import ConnectedSession
from robotskin.ports import made_port
from robotskin.rehearsal import Asked, Look
from robotskin.robots.gains import gains_of


@pytest.mark.real_time
def test_the_command_asks_for_touches_of_marked_cells_before_anything_moves(stage: Stage, tmp_path: Path) -> None:
    """A wrong touch is named; once the marked cells were touched, the robot is started."""
    cells = marked_cells(stage.layout)
    told: list[str] = []
    with subprocess.Popen(
        command(stage, "--seconds", "1", touched=True), cwd=tmp_path, stdout=subprocess.PIPE, text=True
    ) as running:
        assert running.stdout is not None
        wrong = 3
        for line in running.stdout:
            told.append(line)
            asked = re.search(r"touch the marked cell (\d+)", line)
            if asked is None:
                continue
            assert np.abs(stage.arm.ask(Look(("arm.velocity",)))[0]).max() < 0.01
            touched, wrong = wrong if wrong is not None else int(asked.group(1)), None
            time.sleep(0.3)
            stage.units.ask(Asked("push", (touched, 8.0)))
            time.sleep(1.0)
            stage.units.ask(Asked("release"))
        assert running.wait(30) in (0, 1), told  # 1: a busy machine made it late, and the guard stopped it
    text = "".join(told)
    assert "found cell 3 on forearm_link at " in text
    assert f"expected cell {cells[0]}" in text
    assert all(f"cell {cell} was touched, as marked" in text for cell in cells)
    assert text.index("as marked") < text.index("running skin_compliance")


@pytest.mark.real_time
def test_a_page_marks_the_cell_and_the_robot_starts_when_it_was_touched(stage: Stage) -> None:
    units = held_units(stage)
    port = made_port(f"ur:{HOST}", ROBOT)
    told: list[str] = []
    try:
        units.await_skin(20.0)
        gains = gains_of(ROBOT)
        session = ConnectedRobot(ROBOT, stage.layout, port, units, gains=PatientGains(gains.robot, gains.values))
        session.settle()
        with ConnectedSession(session, TouchOrder(stage.layout), told.append) as live:
            live.reset()  # starts nothing before the touches
            for cell in marked_cells(stage.layout):
                assert soon(lambda cell=cell: live.snapshot().marked == cell)
                assert f"touch the marked cell {cell}" in live.snapshot().stop_reason
                assert live.snapshot().controller_state not in ("running", "degraded")
                stage.units.ask(Asked("push", (cell, 8.0)))
                assert soon(lambda cell=cell: live.snapshot().marked != cell)
                stage.units.ask(Asked("release"))
            assert soon(lambda: live.snapshot().controller_state in ("running", "degraded"))
            assert live.snapshot().marked is None
        assert live.failure is None
        assert len(told) == 1 + len(marked_cells(stage.layout))
    finally:
        stage.units.ask(Asked("release"))
        port.stop()
        port.close()
        units.close()


def test_no_touch_is_told_with_the_way_to_go_on_without(stage: Stage) -> None:
    units = held_units(stage)
    port = made_port(f"ur:{HOST}", ROBOT)
    try:
        units.await_skin(20.0)
        session = ConnectedRobot(ROBOT, stage.layout, port, units)
        with pytest.raises(ConnectError, match="no touch of the marked cell within 0 s; --skip-touch"):
            session.check_order(TouchOrder(stage.layout), lambda _: None, 0.2)
    finally:
        port.close()
        units.close()
