# SPDX-License-Identifier: Apache-2.0
"""The guard where joints have interfaces of their own: each keeps the limits of its own, and a stop stops them all."""

import numpy as np
import pytest
from guard_bench import Bench

from robotskin.cycle import Limit, SafetyState
from robotskin.model import CommandMode, RobotModel

POSITION, VELOCITY, TORQUE = CommandMode.position, CommandMode.velocity, CommandMode.torque
ARM = np.array([True, True, True, False, False, False])
MODES = [VELOCITY, POSITION, VELOCITY, TORQUE, TORQUE, TORQUE]


@pytest.fixture
def bench(ur5: RobotModel) -> Bench:
    return Bench(ur5).started(MODES)


def test_a_sound_command_passes_unchanged(bench: Bench) -> None:
    value = bench.neutral(MODES) + 1e-6
    report = bench.check(MODES, value)
    np.testing.assert_array_equal(bench.command.value, value)
    assert bench.command.modes == MODES
    assert (report.send, report.interventions) == (True, 0)


def test_random_commands_leave_within_the_limits_of_each_joint(bench: Bench, seed: int) -> None:
    rng, period = np.random.default_rng(seed), bench.limits.period_s
    last, speed = bench.command.value.copy(), np.zeros(6)
    by_position = np.array([mode == POSITION for mode in MODES])
    for _ in range(300):
        report = bench.check(MODES, rng.normal(0, 1, 6) * 10.0 ** rng.uniform(-3, 5))
        value = bench.command.value.copy()
        assert report.state == SafetyState.running
        assert (np.abs(value[~ARM]) <= bench.robot.effort_limit[~ARM]).all()
        assert (np.abs(value - last)[~ARM] <= 20000 * period + 1e-9).all()
        now = np.where(by_position, (value - last) / period, value)
        assert (np.abs(now)[ARM] <= 0.95 * bench.robot.velocity_limit[ARM] + 1e-9).all()
        assert (np.abs(now - speed)[ARM] <= 100 * period + 1e-6).all()
        bench.joints.position[by_position] = value[by_position]
        last, speed = value, now
    assert report.interventions > 100


@pytest.mark.parametrize(("joint", "change", "limit"), [(0, 0.5, Limit.acceleration), (4, 40.0, Limit.torque_rate)])
def test_a_jump_is_told_with_its_joint_and_leaves_the_others_as_they_are(
    bench: Bench, joint: int, change: float, limit: Limit
) -> None:
    value = bench.neutral(MODES)
    value[joint] += change
    report = bench.check(MODES, value)
    assert (report.interventions, report.limit, report.limited_joint) == (1, limit, joint)
    others = np.arange(6) != joint
    np.testing.assert_allclose(bench.command.value[others], value[others], atol=1e-9)


def test_a_stop_brakes_and_holds_joints_of_every_interface(bench: Bench) -> None:
    bench.joints.velocity[:] = [0.0, 0.0, 0.0, 0.2, -0.1, 0.1]
    period = bench.limits.period_s
    bench.check(MODES, np.where(ARM, bench.neutral(MODES), 0.0))
    for _ in range(1000):
        bench.check(MODES, np.zeros(6), finite=False)
        value = bench.command.value.copy()
        before = bench.joints.velocity.copy()
        after = np.where([mode == POSITION for mode in MODES], (value - bench.joints.position) / period, value)
        mass = np.array(bench.dynamics.mass_matrix)
        left = value - np.array(bench.dynamics.nonlinear_effects) - mass[:, ARM] @ (after - before)[ARM] / period
        after[~ARM] = before[~ARM] + period * np.linalg.solve(mass[np.ix_(~ARM, ~ARM)], left[~ARM])
        bench.joints.velocity = after
        bench.joints.position = bench.joints.position + period * after
    np.testing.assert_allclose(bench.joints.velocity, 0, atol=1e-3)
    np.testing.assert_allclose(bench.command.value[~ARM], bench.dynamics.gravity_torque[~ARM], atol=0.1)
