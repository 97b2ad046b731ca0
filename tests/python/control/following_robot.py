# SPDX-License-Identifier: Apache-2.0
"""A controller on a robot that follows its position commands exactly."""

from robotskin import robots
from robotskin.control import Controller, Fusion
from robotskin.cycle import SafetyState
from robotskin.layout import finished
from robotskin.model import CommandMode, JointCommand, JointState
from robotskin.robots.gains import GainSet
from robotskin.skin import Health, SkinState


class FollowingRobot:
    """A robot in its finished skin, nothing on it; it is asked to run from the first period on."""

    def __init__(self, name: str, start: str = "skin_compliance", fusion: Fusion | None = None) -> None:
        self.robot, self.skin_model, self.gains = (
            robots.load(name).core,
            finished(name).skin_model(),
            GainSet.load(name),
        )
        self.controller = Controller(self.robot, self.skin_model, self.gains, start, fusion=fusion)
        count = self.robot.joint_count
        self.joints, self.command = JointState(count), JointCommand(CommandMode.position, count)
        self.joints.position = self.gains.home
        self.skin = SkinState(len(self.skin_model))
        self.skin.health[:] = Health.alive.value
        self.now_ns = 10**9
        self.controller.request_run(True)

    def run(self, seconds: float) -> SafetyState:
        for _ in range(round(1000 * seconds)):
            self.now_ns += 1_000_000
            self.joints.stamp_ns = self.skin.time_ns = self.now_ns
            report = self.controller.step(self.joints, self.skin, self.now_ns, self.command)
            if report.send:
                self.joints.velocity = (self.command.value - self.joints.position) / 0.001
                self.joints.position = self.command.value.copy()
        return report.state
