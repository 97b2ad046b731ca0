# SPDX-License-Identifier: Apache-2.0
"""Command interfaces by limb: wrists by torque on an arm by velocity give way as one robot."""

from pathlib import Path

import numpy as np
import pytest

from robotskin import layout, robots
from robotskin.control.state_log import write_state_log
from robotskin.cycle import SafetyState
from robotskin.errors import InputError, UnknownNameError
from robotskin.model import CommandMode
from robotskin.session import Session
from robotskin.session.interfaces import modes_by_joint, told
from robotskin.session.touches import pushed_cell

WRISTS = dict.fromkeys(("wrist_1_joint", "wrist_2_joint", "wrist_3_joint"), "torque")
UPPER = dict.fromkeys(("shoulder_pan_joint", "shoulder_lift_joint", "elbow_joint"), "velocity")


def test_a_limb_gives_its_joints_their_interface_and_a_joint_its_own() -> None:
    hand = robots.load("allegro_grasp").core
    fingers = dict.fromkeys(("index", "middle", "ring", "thumb"), "torque")
    modes = modes_by_joint(hand, {"carriage": "velocity", **fingers, "joint_3.0": CommandMode.position})
    by_name = dict(zip(hand.joint_names, modes, strict=True))
    assert by_name.pop("lift") is CommandMode.velocity
    assert by_name.pop("joint_3.0") is CommandMode.position
    assert set(by_name.values()) == {CommandMode.torque}
    words = told(hand, modes_by_joint(hand, {"carriage": "velocity", **fingers}))
    assert words == "carriage by velocity, others by torque"
    with pytest.raises(UnknownNameError, match="arm"):
        modes_by_joint(hand, {"arm": "velocity"})
    with pytest.raises(InputError, match="none for lift"):
        modes_by_joint(hand, fingers)


def test_a_robot_of_two_interfaces_gives_way_as_it_does_by_one(seed: int, tmp_path: Path) -> None:
    gave = []
    for interface in ("velocity", UPPER | WRISTS):
        session = Session(robots.load("ur5"), layout.finished("ur5"), seed=seed, link="in process", interface=interface)
        try:
            session.boot()
            before = np.array(session.joints.position)
            session.world.push(pushed_cell(session, "forearm_link"), 10.0)
            session.run(1.0)
            assert session.state is SafetyState.running
            assert session.controller.report.violations == 0
            gave.append(np.array(session.joints.position) - before)
            path = tmp_path / "log.csv"
            write_state_log(path, session.controller.cycle.log, session.robot.joint_names, "asked")
        finally:
            session.shut_down()
    assert np.abs(gave[1] - gave[0]).max() < 0.15 * np.abs(gave[0]).max()
    assert session.interface == ", ".join([*(f"{joint} by velocity" for joint in UPPER), "others by torque"])
    assert session.interfaces == ("position", "velocity", "torque", session.interface)
    assert "velocity; velocity; velocity; torque; torque; torque" in path.read_text().splitlines()[-1]
