# SPDX-License-Identifier: Apache-2.0
"""A guard on a robot with everything in order, for tests to bring out of order."""

from collections.abc import Sequence

import numpy as np

from robotskin.cycle import Guard, GuardLimits, SafetyState
from robotskin.model import CommandMode, JointCommand, JointState, RobotDynamics
from robotskin.skin import Health, SkinState

PERIOD_NS = 1_000_000


class Bench:
    """A guard on the UR5, or one that holds something, with everything in order."""

    def __init__(self, ur5, **limits: float) -> None:
        self.robot, count = ur5, ur5.joint_count
        self.limits = GuardLimits([100.0] * count, [10.0] * count, [20000.0] * count)
        for name, value in limits.items():
            setattr(self.limits, name, value)
        self.guard = Guard(ur5, self.limits)
        self.dynamics = RobotDynamics(ur5)
        self.joints, self.skin = JointState(count), SkinState(100)
        self.joints.position[:6] = [0.0, -1.4, 1.5, -1.6, -1.5, 0.0]
        self.skin.health[:] = Health.alive.value
        self.command = JointCommand(CommandMode.position, count)
        self.now_ns, self.joints_age_ns, self.skin_age_ns = 10**9, 0, 0

    def check(
        self, mode: CommandMode | Sequence[CommandMode], value: np.ndarray, wanted: bool = True, finite: bool = True
    ):
        self.now_ns += PERIOD_NS
        self.joints.stamp_ns = self.now_ns - self.joints_age_ns
        self.skin.time_ns = self.now_ns - self.skin_age_ns
        if np.isfinite(self.joints.position).all() and np.isfinite(self.joints.velocity).all():
            self.dynamics.update(self.joints.position.copy(), self.joints.velocity.copy())
        if isinstance(mode, CommandMode):
            self.command.mode = mode
        else:
            self.command.modes = list(mode)
        self.command.value = np.asarray(value, dtype=float)
        return self.guard.check(self.dynamics, self.joints, self.skin, self.now_ns, wanted, finite, self.command)

    def neutral(self, mode: CommandMode | Sequence[CommandMode]) -> np.ndarray:
        if not isinstance(mode, CommandMode):
            each = {one: self.neutral(one) for one in CommandMode}
            return np.array([each[one][joint] for joint, one in enumerate(mode)])
        if mode == CommandMode.position:
            return self.joints.position.copy()
        if mode == CommandMode.velocity:
            return np.zeros(self.robot.joint_count)
        self.dynamics.update(self.joints.position.copy(), self.joints.velocity.copy())
        return self.dynamics.gravity_torque

    def started(self, mode: CommandMode | Sequence[CommandMode]) -> "Bench":
        for _ in range(3):
            report = self.check(mode, self.neutral(mode))
        assert report.state == SafetyState.running
        return self
