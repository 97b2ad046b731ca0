# SPDX-License-Identifier: Apache-2.0
"""The task cycle: any stack, without torque jumps, refusing what does not fit before the robot moves."""

from types import SimpleNamespace

import numpy as np
import pytest

from robotskin.cycle import SafetyState, TaskCycle
from robotskin.model import CommandMode, JointCommand, JointState, RobotModel
from robotskin.robots.gains import GainSet
from robotskin.skin import Health, SkinModel, SkinState
from robotskin.tasks import (
    FEEDFORWARD,
    CartesianGains,
    CartesianTask,
    ControlError,
    Fusion,
    GravityTask,
    JointLimitTask,
    JointTask,
    PythonTask,
    QuadraticLimits,
    SkinReactionTask,
    StackEntry,
    TouchWrench,
)

PERIOD_S = 0.001
FADE_S = 0.25


class Rig(SimpleNamespace):
    """A task cycle on a robot that follows its position commands, or is frozen."""

    def __init__(self, robot: RobotModel, skin: SkinModel) -> None:
        self.robot, self.model = robot, skin
        self.gain_set = GainSet.load("ur5")
        self.gains = self.gain_set.cycle_gains(robot, skin)
        self.joint = JointTask(robot, self.gain_set.joint, "posture")
        touch = TouchWrench(robot, skin, self.gain_set.skin_gains(robot, skin))
        self.touch = SkinReactionTask(touch, self.gains.touch_bandwidth_hz)
        self.gravity = GravityTask(robot.joint_count)
        self.hand = CartesianTask(robot, "ee_link", CartesianGains([500.0] * 3 + [20.0] * 3, [20.0] * 3 + [1.0] * 3))
        self.limits = JointLimitTask(robot)
        self.cycle = self.make(self.compliance())
        self.joints = JointState(robot.joint_count)
        self.joints.position[:] = self.gain_set.home
        self.skin = SkinState(len(skin))
        self.skin.health[:] = Health.alive.value
        self.command = JointCommand(CommandMode.position, robot.joint_count)
        self.now_ns = 10**9

    def make(self, entries: list[StackEntry], fusion: Fusion = Fusion.weighted_sum) -> TaskCycle:
        self.gains.fade_s = FADE_S
        limits = self.gain_set.guard_limits(self.robot)
        return TaskCycle(self.robot, self.model, self.gains, limits, entries, fusion)

    def compliance(self) -> list[StackEntry]:
        return [StackEntry(self.joint), StackEntry(self.touch), StackEntry(self.gravity, FEEDFORWARD)]

    def step(self, cycle=None, frozen: bool = False):
        self.now_ns += 1_000_000
        self.joints.stamp_ns = self.skin.time_ns = self.now_ns
        report = (cycle or self.cycle).step(self.joints, self.skin, self.now_ns, self.command)
        if report.send and not frozen and self.command.mode == CommandMode.position:
            self.joints.velocity = (self.command.value - self.joints.position) / PERIOD_S
            self.joints.position = self.command.value.copy()
        return report

    def run(self, steps: int = 3, **options):
        self.cycle.request_run(True)
        for _ in range(steps):
            report = self.step(**options)
        return report


@pytest.fixture
def rig(ur5: RobotModel, skin: SkinModel) -> Rig:
    return Rig(ur5, skin)


def stacks(rig: Rig) -> list[tuple[list[StackEntry], Fusion]]:
    gravity = StackEntry(rig.gravity, FEEDFORWARD)
    return [
        (rig.compliance(), Fusion.weighted_sum),
        ([gravity, StackEntry(rig.hand, 0), StackEntry(rig.joint, 1)], Fusion.null_space),  # inserted
        ([gravity, StackEntry(rig.joint, 0), StackEntry(rig.hand, 1)], Fusion.null_space),  # re-ranked
        ([gravity, StackEntry(rig.touch, 0), StackEntry(rig.hand, 1), StackEntry(rig.joint, 2)], Fusion.null_space),
        ([gravity, StackEntry(rig.touch, 0)], Fusion.null_space_at_rest),  # removed
        ([StackEntry(rig.joint, 0, 0.1), gravity], Fusion.weighted_sum),  # another weight
        ([StackEntry(rig.gravity)], Fusion.weighted_sum),
    ]


def test_no_torque_jumps_whatever_is_switched(rig, push_cell) -> None:
    """On a frozen state: nothing at the switch, and 2 |change| dt / T a tick afterwards at most."""
    rig.cycle.request_mode(CommandMode.torque)
    rig.run(50, frozen=True)
    rig.joint.request_reference(rig.gain_set.home + 0.2)
    rig.hand.request_reference(np.eye(4))
    rig.skin.normal_force[push_cell] = 1.5
    for _ in range(400):
        rig.step(frozen=True)
    for entries, fusion in [*stacks(rig), *stacks(rig)[::-1]]:
        before = rig.cycle.fused_torque
        rig.cycle.request_stack(entries, fusion)
        torques = [before]
        for _ in range(400):
            rig.step(frozen=True)
            torques.append(rig.cycle.fused_torque)
        change = np.abs(torques[-1] - torques[0])
        steps = np.abs(np.diff(torques, axis=0))
        assert steps[0].max() <= 1e-3
        # The hand's reference begins anew where its task enters; the rest of the way is the fade.
        assert (steps[1:] <= 2 * change * PERIOD_S / FADE_S + 1e-6).all()
        np.testing.assert_allclose(torques[-1], torques[-100], atol=1e-9)


def test_a_switch_during_a_switch_does_not_jump_either(rig, push_cell) -> None:
    rig.run(50, frozen=True)
    rig.joint.request_reference(rig.gain_set.home + 0.2)
    rig.skin.normal_force[push_cell] = 1.5
    for _ in range(400):
        rig.step(frozen=True)
    choices = stacks(rig)
    last = rig.cycle.fused_torque
    for tick in range(300):
        if tick % 37 == 0:
            rig.cycle.request_stack(*choices[tick // 37 % len(choices)])
        rig.step(frozen=True)
        assert np.abs(rig.cycle.fused_torque - last).max() < 20.0 * 12 * PERIOD_S / FADE_S
        last = rig.cycle.fused_torque


def test_a_stack_requested_before_the_start_is_the_one_that_runs(rig) -> None:
    rig.cycle.request_stack([StackEntry(rig.gravity)], Fusion.weighted_sum)
    rig.run(20)
    np.testing.assert_allclose(rig.joints.position, rig.gain_set.home, atol=1e-9)


def test_tasks_of_the_same_touch_share_what_it_computes_in_a_tick(rig, ur5, skin, push_cell) -> None:
    """A task between two others changes the skin in mid-tick: what they share was computed before."""
    gains = rig.gain_set.skin_gains(ur5, skin)
    shared, own = TouchWrench(ur5, skin, gains), TouchWrench(ur5, skin, gains)

    def let_go(dynamics, position, velocity, felt):
        felt.normal_force[push_cell] = 0.0
        return np.zeros(6), np.zeros((0, 6))

    first, second, third = SkinReactionTask(shared), SkinReactionTask(shared), SkinReactionTask(own)
    tasks = [first, PythonTask("let go", 6, 0, let_go), second, third, rig.gravity]
    rig.cycle.request_stack([StackEntry(task) for task in tasks], Fusion.weighted_sum)
    for _ in range(3):
        rig.skin.normal_force[push_cell] = 2.0
        rig.step()
        assert np.abs(first.host_torque).max() > 1
        np.testing.assert_array_equal(first.host_torque, second.host_torque)
        np.testing.assert_array_equal(third.host_torque, np.zeros(6))


def test_skin_off_means_that_no_task_feels_anything(rig, push_cell) -> None:
    rig.cycle.request_skin(False)
    rig.run(400, frozen=True)
    calm = rig.cycle.fused_torque
    rig.skin.normal_force[push_cell] = 2.0
    rig.step(frozen=True)
    np.testing.assert_allclose(rig.cycle.fused_torque, calm, atol=1e-9)
    rig.cycle.request_skin(True)
    for _ in range(400):
        rig.step(frozen=True)
    assert np.abs(rig.cycle.fused_torque - calm).max() > 1


def test_a_task_without_an_answer_stops_the_robot(rig) -> None:
    good = [True]

    def compute(dynamics, position, velocity, skin):
        return np.zeros(6) if good[0] else np.full(6, np.nan), np.zeros((0, 6))

    mine = PythonTask("mine", 6, 0, compute)
    rig.cycle.request_stack([StackEntry(mine), StackEntry(rig.joint), StackEntry(rig.gravity, -1)], Fusion.weighted_sum)
    assert rig.run(20).state == SafetyState.running
    good[0] = False
    assert rig.step().state == SafetyState.stopped
    assert "not finite" in rig.cycle.report.text


def test_the_last_second_is_kept_where_a_fault_stopped_the_robot(rig) -> None:
    rig.run(1500)
    stopped_at = rig.now_ns + 1_000_000
    rig.joints.position = np.full(6, np.nan)
    rig.step()
    for _ in range(30):
        rig.step()
    assert rig.cycle.report.state == SafetyState.stopped
    log = rig.cycle.log
    assert log["values"].shape == (1000, 4, 6)
    assert log["time_ns"][-1] == stopped_at - 1_000_000
    assert (np.diff(log["time_ns"]) == 1_000_000).all()
    np.testing.assert_allclose(log["values"][:, 0], np.tile(rig.gain_set.home, (1000, 1)), atol=1e-6)


def test_what_does_not_fit_is_refused_before_the_robot_moves(rig, ur5) -> None:
    with pytest.raises(ControlError, match="no task"):
        rig.make([])
    with pytest.raises(ControlError, match="7"):
        rig.make([StackEntry(GravityTask(7))])
    with pytest.raises(ControlError, match="limits"):
        rig.cycle.request_stack([StackEntry(rig.gravity)], Fusion.quadratic)
    limits = QuadraticLimits.of(ur5)
    limits.torque = [1.0]
    with pytest.raises(ControlError, match="torque has 1 values"):
        rig.cycle.request_stack([StackEntry(rig.gravity)], Fusion.quadratic, quadratic=limits)
    assert rig.run(10).state == SafetyState.running, "what was refused left the stack as it was"


@pytest.mark.parametrize("mode", list(CommandMode))
@pytest.mark.parametrize("fusion", list(Fusion))
def test_every_fusion_runs_through_every_interface(rig, ur5, push_cell, fusion, mode) -> None:
    limits = QuadraticLimits.of(ur5)
    rig.cycle.request_mode(mode)
    rig.cycle.request_stack(
        [
            StackEntry(rig.gravity, FEEDFORWARD),
            StackEntry(rig.limits, 0),
            StackEntry(rig.touch, 1),
            StackEntry(rig.joint, 2),
        ],
        fusion,
        quadratic=limits,
    )
    rig.skin.normal_force[push_cell] = 1.0
    assert rig.run(30, frozen=mode != CommandMode.position).state == SafetyState.running
    assert np.isfinite(rig.command.value).all()
    assert np.abs(rig.cycle.fused_torque).max() > 1
