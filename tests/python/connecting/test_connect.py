# SPDX-License-Identifier: Apache-2.0
"""A robot and a skin behind real sockets: refused before anything moves where they are not the expected, else run."""

import contextlib
import json
import signal
import socket
import subprocess
import threading
import time
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from other_version import OtherVersion
from staged import HOST, ROBOT, PatientGains, Stage, command, held_units, soon
from typer.testing import CliRunner

from patience import runs_until
from robotskin import firmware
from robotskin import layout as layouts
from robotskin.cli.main import app
from robotskin.connecting import (
    ConnectedRobot,
    ConnectError,
    check_before_motion,
    unit_addresses,
)
from robotskin.cycle import SafetyState
from robotskin.keys import SkinKeys
from robotskin.live.connected_session import ConnectedSession
from robotskin.model import CommandMode, JointState, PortStatus, RobotDynamics, RobotPort
from robotskin.ports import PortError, made_port
from robotskin.rehearsal import Asked, Look
from robotskin.robots.gains import gains_of
from robotskin.session import SessionError
from robotskin.session.goals import GoalWatch
from robotskin.simulator import SensorFaultKind
from robotskin_lab.partial_skin import part_of

ILL_CELL = 5


@pytest.mark.real_time
def test_the_robot_gives_way_and_comes_back_and_stops_with_its_skin(stage: Stage) -> None:
    units = held_units(stage)
    port = made_port(f"ur:{HOST}", ROBOT)
    try:
        assert units.await_skin(20.0) == len(stage.layout)
        gains = gains_of(ROBOT)
        session = ConnectedRobot(
            ROBOT, stage.layout, port, units, gains=PatientGains(gains.robot, gains.values), speed_share=0.2
        )
        assert "efforts agree" in session.seen[1]
        session.begin(within_s=20.0)
        home = np.array(session.joints.position)
        stage.units.ask(Asked("push", (3, 10.0)))
        assert runs_until(session, lambda: np.abs(np.array(session.joints.position) - home).max() > 0.03)
        assert session.felt_force_n() > 5.0
        true = stage.arm.ask(Look(("arm.position",)))[0]
        assert np.abs(true - home).max() > 0.02  # it is the controller's arm that moved
        assert not session.confirmed
        assert np.abs(session.joints.velocity).max() < 0.2 * ROBOT.velocity_limit.max()
        stage.units.ask(Asked("release"))
        assert runs_until(session, lambda: np.abs(np.array(session.joints.position) - home).max() < 0.01)
        assert session.latency()["command_median_s"] < 0.002
        session.confirm()
        assert session.confirmed
        units.driver.stop()  # nothing comes from the skin any more
        session.run(1.0)
        assert session.state in (SafetyState.stopped, SafetyState.ready)
        assert "skin" in session.why_not_running()
        assert np.abs(stage.arm.ask(Look(("arm.velocity",)))[0]).max() < 0.01
        assert session.controller.report.violations == 0
    finally:
        port.close()
        units.close()


def test_a_wrong_key_is_told(stage: Stage) -> None:
    units = held_units(stage, SkinKeys.fresh())
    with pytest.raises(ConnectError, match="no answer: it is not there, or it has another key"):
        units.await_skin(1.0)
    units.close()


def test_a_wrong_address_is_told(stage: Stage) -> None:
    units = held_units(stage, addresses=[("127.0.0.1", 9)])
    with pytest.raises(ConnectError, match=r"127\.0\.0\.1:9: nothing is at this port"):
        units.await_skin(0.5)
    units.close()


def test_another_layout_is_told(stage: Stage) -> None:
    whole = layouts.finished("ur5")
    other = part_of(whole, np.flatnonzero(whole.patch == whole.patch[172]))
    units = held_units(stage, layout=other)
    with pytest.raises(ConnectError, match="found cells that layout ur5 of 85 cells does not have"):
        units.await_skin(3.0)
    units.close()


def test_a_layout_with_the_same_cells_at_other_places_is_told(stage: Stage) -> None:
    units = held_units(stage, layout=replace(stage.layout, id=np.roll(stage.layout.id, 1)))
    with pytest.raises(ConnectError, match=r"found \d+ of \d+ wires that layout ur5 of \d+ cells does not have"):
        units.await_skin(20.0)
    units.close()


@pytest.mark.parametrize(("of_unit", "told"), [(False, "in 8 cells"), (True, r"section unit \d+\.\d+")])
def test_firmware_of_another_version_is_told(stage: Stage, of_unit: bool, told: str) -> None:
    keys = SkinKeys.load(stage.key)
    with OtherVersion(tuple(stage.addresses[0]), keys.datagram_key, 9, of_unit=of_unit) as between:
        units = held_units(stage, addresses=[between.address])
        with pytest.raises(ConnectError, match=told) as refused:
            units.await_skin(20.0)
        units.close()
    assert "9" in str(refused.value)
    assert f"expected {firmware.FIRMWARE_VERSION}" in str(refused.value)


def test_a_unit_of_other_datagrams_is_told(stage: Stage) -> None:
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as unit:
        unit.bind(("127.0.0.1", 0))

        def answer() -> None:
            with contextlib.suppress(OSError):
                while True:
                    _, host = unit.recvfrom(2048)
                    unit.sendto(firmware.DATAGRAM_MAGIC.to_bytes(4, "big") + b"\x07", host)

        threading.Thread(target=answer, daemon=True).start()
        units = held_units(stage, addresses=[unit.getsockname()])
        with pytest.raises(ConnectError, match=f"found datagrams of version 7, expected {firmware.DATAGRAM_VERSION}"):
            units.await_skin(1.0)
        units.close()


def test_a_count_of_units_that_the_layout_does_not_have(stage: Stage) -> None:
    with pytest.raises(ConnectError, match="found 2 addresses, the layout has 1"):
        held_units(stage, addresses=stage.addresses * 2)


@pytest.mark.parametrize("text", ["", "here", "10.0.0.1:", "10.0.0.1:99999", ":80"])
def test_an_address_that_is_none(text: str) -> None:
    with pytest.raises(ConnectError, match="give HOST:PORT"):
        unit_addresses([text])


class Still(RobotPort):
    """At home, at rest, with an effort."""

    def __init__(self, position, effort, velocity=0.0) -> None:
        super().__init__(6, [CommandMode.position])
        self.position, self.effort, self.velocity = position, effort, velocity

    def read(self, state: JointState) -> PortStatus:
        state.position, state.effort, state.velocity = self.position, self.effort, np.full(6, self.velocity)
        state.stamp_ns = time.monotonic_ns()
        return PortStatus.ok


HOME = gains_of(ROBOT).home


def weight(position) -> np.ndarray:
    dynamics = RobotDynamics(ROBOT.core)
    dynamics.update(position, np.zeros(6))
    return dynamics.gravity_torque


@pytest.mark.parametrize("joint", [1, 2])
def test_a_joint_with_a_turned_sign_is_found_by_its_weight(joint: int) -> None:
    turned = HOME.copy()
    turned[joint] = -turned[joint]
    with pytest.raises(ConnectError, match="check signs and zeros"):
        check_before_motion(ROBOT, Still(turned, weight(HOME)))


def test_what_the_first_look_refuses() -> None:
    assert "efforts agree" in check_before_motion(ROBOT, Still(HOME, weight(HOME)))[1]
    assert "not checked" in check_before_motion(ROBOT, Still(HOME, np.zeros(6)))[1]
    with pytest.raises(ConnectError, match=r"found moving at 0\.500"):
        check_before_motion(ROBOT, Still(HOME, weight(HOME), 0.5))
    beyond = HOME.copy()
    beyond[2] = 7.0
    with pytest.raises(ConnectError, match=r"found at 7.000, expected between"):
        check_before_motion(ROBOT, Still(beyond, weight(HOME)))


def test_a_port_of_another_count_of_joints(tmp_path: Path, monkeypatch) -> None:
    (tmp_path / "two_joints.py").write_text(
        "from robotskin.model import CommandMode, RobotPort\n"
        "class Two(RobotPort):\n    def __init__(self):\n        super().__init__(2, [CommandMode.position])\n"
    )
    monkeypatch.chdir(tmp_path)
    with pytest.raises(PortError, match="found 2 joints, ur5 has 6"):
        made_port("two_joints", ROBOT)


@pytest.mark.real_time
def test_what_a_page_sees_and_asks_of_a_connected_robot(stage: Stage, monkeypatch) -> None:
    looks: list[float] = []
    look = GoalWatch.look
    monkeypatch.setattr(GoalWatch, "look", lambda self: (looks.append(time.monotonic()), look(self))[1])
    units = held_units(stage)
    port = made_port(f"ur:{HOST}", ROBOT)
    try:
        units.await_skin(20.0)
        gains = gains_of(ROBOT)
        session = ConnectedRobot(ROBOT, stage.layout, port, units, gains=PatientGains(gains.robot, gains.values))
        session.begin(within_s=20.0)
        with ConnectedSession(session) as live:
            time.sleep(2.0)
            assert np.diff(looks[1:]).min() > 0.4  # "has arrived" is judged by what moved between two looks
            seen = live.snapshot()
            assert len(seen.skin.health) == len(stage.layout)
            assert np.isfinite(seen.skin.age_s).all()
            assert "slow until confirmed" in seen.held_back
            stage.units.ask(Asked("world.body.set_sensor_fault", (ILL_CELL, SensorFaultKind.end_of_range, [4], 1.0)))
            ends = time.monotonic() + 180.0
            while ILL_CELL not in session.left_out and time.monotonic() < ends:
                time.sleep(0.02)
            assert "end of range" in live.snapshot().skin.ill[ILL_CELL]
            assert session.left_out == {ILL_CELL}
            stage.units.ask(Asked("world.body.set_sensor_fault", (ILL_CELL, SensorFaultKind.none)))
            with pytest.raises(SessionError, match="touch the skin itself"):
                live.push(0, 5.0)
            with pytest.raises(SessionError, match="no simulated hand"):
                live.approach(0, 0.05)
            lookers = [1]
            live.watch_page(lambda: lookers[0])
            time.sleep(0.2)
            lookers[0] = 0
            ends = time.monotonic() + 10.0
            while "the page was lost" not in live.snapshot().stop_reason and time.monotonic() < ends:
                time.sleep(0.02)
            assert live.snapshot().stop_reason == "the page was lost"

            def runs() -> bool:
                return live.snapshot().controller_state in ("running", "degraded")

            lookers[0] = 1
            time.sleep(0.2)
            live.reset()  # it waits until the robot is at rest, whatever it did before
            assert soon(runs)
            asked: list[float] = []
            stop = session.stop
            monkeypatch.setattr(session, "stop", lambda: (asked.append(time.monotonic()), stop()))
            lookers[0] = 0
            live.look_for_page()  # as the server's thread does that hears it first
            assert asked
            assert soon(lambda: not runs())
            lookers[0] = 1
            live.reset()
            live.stop()  # a later stop takes the start back
            assert soon(lambda: not runs() and not live.snapshot().stop_reason.startswith("the page"))
            time.sleep(1.0)
            assert not runs()
        assert live.failure is None
    finally:
        port.stop()
        port.close()
        units.close()


@pytest.mark.real_time
def test_sigterm_stops_the_robot(stage: Stage, tmp_path: Path) -> None:
    with subprocess.Popen(
        command(stage, "--json", "figures.json"), cwd=tmp_path, stdout=subprocess.PIPE, text=True
    ) as running:
        told = []
        assert running.stdout is not None
        for line in running.stdout:
            told.append(line)
            if "running" in line:
                break
        assert "at most 20%" in told[-1], told
        time.sleep(0.3)
        running.send_signal(signal.SIGTERM)
        # 1: a busy machine made it late, and the guard stopped it before; 130: it had just ended when the signal came.
        assert running.wait(20) in (0, 1, 130)
    figures = json.loads((tmp_path / "figures.json").read_text())
    assert figures["stop_s"] < 1.0
    assert figures["limit_violations"] == 0
    assert np.abs(stage.arm.ask(Look(("arm.velocity",)))[0]).max() < 0.01


def test_the_command_refuses_firmware_of_another_version_before_anything_moves(stage: Stage, tmp_path, monkeypatch):
    before = stage.arm.ask(Look(("script_name",)))[0]
    monkeypatch.chdir(tmp_path)
    with OtherVersion(tuple(stage.addresses[0]), SkinKeys.load(stage.key).datagram_key, 9) as between:
        ran = CliRunner().invoke(app, command(stage, unit=between.address)[1:])
    assert ran.exit_code == 2
    assert "firmware of another version" in " ".join(ran.output.split())
    assert stage.arm.ask(Look(("script_name",)))[0] == before


def test_the_command_refuses_before_anything_moves(stage: Stage, tmp_path: Path, monkeypatch) -> None:
    SkinKeys.fresh().save(tmp_path / "other.key")
    before = stage.arm.ask(Look(("script_name",)))[0]
    monkeypatch.chdir(tmp_path)
    ran = CliRunner().invoke(app, command(stage, key=tmp_path / "other.key")[1:])
    assert ran.exit_code == 2
    assert "another key" in ran.output
    assert stage.arm.ask(Look(("script_name",)))[0] == before
