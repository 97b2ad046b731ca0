# SPDX-License-Identifier: Apache-2.0
"""A joint that something presses onto its end: how far beyond its limit the guard lets it be."""

import pytest
from guard_bench import Bench

from robotskin import robots
from robotskin.cycle import Reason, SafetyState
from robotskin.model import CommandMode

RUNNING, STOPPED = SafetyState.running, SafetyState.stopped
POSITION = CommandMode.position
MODES = [CommandMode.position, CommandMode.velocity, CommandMode.torque]


@pytest.mark.parametrize("mode", MODES)
@pytest.mark.parametrize("side", ["lower", "upper"])
@pytest.mark.parametrize("tolerance", [0.0, 0.002])
def test_a_joint_that_is_pressed_onto_its_end_runs_on_up_to_the_tolerance(ur5, mode, side, tolerance) -> None:
    bench = Bench(ur5, end_tolerance=tolerance).started(mode)
    end, outwards = (ur5.upper[2], 1) if side == "upper" else (ur5.lower[2], -1)
    bench.joints.position[2] = end + outwards * 0.99 * tolerance
    report = bench.check(mode, bench.neutral(mode))
    assert (report.state, report.violations) == (RUNNING, 0)
    bench.joints.position[2] = end + outwards * (1.01 * tolerance + 1e-6)
    report = bench.check(mode, bench.neutral(mode))
    assert (report.state, report.reason, report.violations) == (STOPPED, Reason.joints_beyond, 1)


def test_a_joint_of_little_room_has_little_tolerance() -> None:
    robot = robots.load("ur5_gripper").core
    bench = Bench(robot).started(POSITION)
    jaw = list(robot.joint_names).index("left_pad_joint")
    bench.joints.position[jaw] = robot.upper[jaw] + 0.0003  # of 50 mm
    assert bench.check(POSITION, bench.neutral(POSITION)).reason == Reason.joints_beyond
