# SPDX-License-Identifier: Apache-2.0
from types import SimpleNamespace

import numpy as np
import pytest

from robotskin import robots
from robotskin.control import Controller
from robotskin.layout import finished
from robotskin.model import CommandMode, JointCommand, JointState, RobotModel
from robotskin.robots.gains import GainSet
from robotskin.skin import Health, SkinModel, SkinState

PERIOD_NS = 1_000_000


@pytest.fixture(scope="session")
def ur5() -> RobotModel:
    return robots.load("ur5").core


@pytest.fixture(scope="session")
def skin() -> SkinModel:
    return finished("ur5").skin_model()


class Rig(SimpleNamespace):
    """Skin compliance on a robot that does exactly what it is told with the position and velocity interfaces."""

    def __init__(self, robot: RobotModel, skin: SkinModel, gains: GainSet | None = None) -> None:
        self.gains = gains or GainSet.load("ur5")
        self.cycle = Controller(robot, skin, self.gains).cycle
        self.joints = JointState(robot.joint_count)
        self.joints.position[:] = self.gains.home
        self.skin = SkinState(len(skin))
        self.skin.health[:] = Health.alive.value
        self.command = JointCommand(CommandMode.position, robot.joint_count)
        self.now_ns = 10**9

    def step(self, move: bool = True, joints_fresh: bool = True, skin_fresh: bool = True):
        self.now_ns += PERIOD_NS
        if joints_fresh:
            self.joints.stamp_ns = self.now_ns
        if skin_fresh:
            self.skin.time_ns = self.now_ns
        report = self.cycle.step(self.joints, self.skin, self.now_ns, self.command)
        if move and report.send:
            self.follow()
        return report

    def follow(self) -> None:
        if self.command.mode == CommandMode.position:
            self.joints.velocity = (self.command.value - self.joints.position) / (PERIOD_NS * 1e-9)
            self.joints.position = self.command.value.copy()
        elif self.command.mode == CommandMode.velocity:
            self.joints.velocity = self.command.value.copy()
            self.joints.position = self.joints.position + self.command.value * PERIOD_NS * 1e-9

    def run(self, steps: int = 3, mode: CommandMode = CommandMode.position, **options: bool):
        self.cycle.request_mode(mode)
        self.cycle.request_run(True)
        for _ in range(steps):
            report = self.step(**options)
        return report

    def touch(self, cell: int, force_n: float) -> None:
        self.skin.normal_force[:] = 0
        self.skin.normal_force[cell] = force_n / 3


@pytest.fixture
def rig(ur5: RobotModel, skin: SkinModel) -> Rig:
    return Rig(ur5, skin)


@pytest.fixture
def push_cell(ur5: RobotModel, skin: SkinModel) -> int:
    """A cell of the forearm that gives way by its full compliance."""
    gains = GainSet.load("ur5")
    soft = gains.stiff_compliance(ur5, skin) * (1 + gains.force_weights(ur5, skin))
    forearm = skin.link == skin.link_names.index("forearm_link")
    return int(np.flatnonzero(forearm & (soft > 0.95 * soft.max()))[0])
