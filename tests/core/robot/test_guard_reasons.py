# SPDX-License-Identifier: Apache-2.0
"""An intervention names the limit and the joint that it was made for."""

import numpy as np
import pytest
from guard_bench import Bench

from robotskin import robots
from robotskin.cycle import Limit
from robotskin.model import CommandMode

POSITION, VELOCITY, TORQUE = CommandMode.position, CommandMode.velocity, CommandMode.torque


@pytest.mark.parametrize("joint", [0, 4])
@pytest.mark.parametrize(
    ("mode", "change", "limit"),
    [
        (POSITION, 1e-3, Limit.acceleration),
        (VELOCITY, 0.5, Limit.acceleration),
        (TORQUE, 40.0, Limit.torque_rate),
    ],
)
def test_a_jump_is_told_with_its_joint(ur5, mode: CommandMode, joint: int, change: float, limit: Limit) -> None:
    bench = Bench(ur5).started(mode)
    value = bench.neutral(mode)
    value[joint] += change
    report = bench.check(mode, value)
    assert (report.interventions, report.limit, report.limited_joint) == (1, limit, joint)


def test_jaws_keep_a_margin_that_leaves_them_room() -> None:
    """A margin for arms, 0.02 rad, would be two fifths of the way of a gripper's jaw."""
    gripper = robots.load("ur5_gripper")
    jaw = gripper.joint_names.index("left_pad_joint")
    room = gripper.upper[jaw] - gripper.lower[jaw]
    for share, held in ((0.8, False), (0.2, False), (0.97, True)):
        bench = Bench(gripper.core)
        bench.joints.position[6:] = gripper.lower[6:] + 0.5 * room
        bench.joints.position[jaw] = gripper.lower[jaw] + share * room
        bench.started(POSITION)
        there = bench.joints.position.copy()
        there[jaw] += 1e-6 * np.sign(share - 0.5)
        assert (bench.check(POSITION, there).interventions > 0) == held, share


def test_a_joint_near_its_end_and_one_that_is_too_fast_are_told_apart(ur5) -> None:
    bench = Bench(ur5, position_margin=0.02)
    bench.joints.position[2] = ur5.upper[2] - 0.021
    bench.started(VELOCITY)
    for speed in np.arange(0.05, 4.0, 0.05):
        value = np.zeros(6)
        value[2] = value[5] = speed
        bench.check(VELOCITY, value)
        if bench.guard.report.limited_joint == 5:
            break
    assert bench.guard.report.limit == Limit.velocity
    value[5] = bench.command.value[5]
    report = bench.check(VELOCITY, value)
    assert (report.limit, report.limited_joint) == (Limit.position, 2)
