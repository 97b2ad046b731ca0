# SPDX-License-Identifier: Apache-2.0
"""An intervention names the limit and the joint that it was made for."""

import numpy as np
import pytest
from guard_bench import Bench

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
