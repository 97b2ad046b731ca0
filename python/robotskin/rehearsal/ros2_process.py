# SPDX-License-Identifier: Apache-2.0
"""A robot under forward controllers of ros2_control that is not there, in a process of its own."""

from __future__ import annotations

import time
from collections.abc import Sequence

import numpy as np
from numpy.typing import ArrayLike

from robotskin import robots
from robotskin.model import CommandMode
from robotskin.rehearsal.process import Process
from robotskin.rehearsal.ur_arm import UrArm
from robotskin.robots import Robot
from robotskin.robots.gains import gains_of
from robotskin.ros2.dds import DdsNode
from robotskin.ros2.joint_messages import COMMANDS, STATES, message_of, states_message
from robotskin.ros2.joints_name import CONTROLLERS
from robotskin.ros2.message_types import cdr
from robotskin.ros2.topic import Topic

STEP_S = 0.002
LOOKAHEAD_S = 0.004
ACCELERATION = 40.0
BEHIND_S = 0.5


class ForwardControllers:
    """Tells joint states, and takes commands on the topics of all three forward controllers; the last one counts.

    As real ones they keep a command for ever. Hardware that adds the robot's weight to efforts: `carries_weight`.
    """

    def __init__(
        self,
        robot: Robot,
        posture: ArrayLike,
        domain: int,
        joint_order: Sequence[str],
        friction: float | None,
        carries_weight: bool,
    ) -> None:
        self.arm = UrArm(robot, posture, friction)
        self.arm.carries_weight = carries_weight
        self.steps = self.commands = 0
        self.telling = True
        """Whether states are told."""
        self._names = list(joint_order)
        self._of_order = np.array([robot.joint_names.index(name) for name in joint_order], dtype=np.intp)
        self._node = DdsNode(domain)
        self._states = Topic("/joint_states", STATES)
        self._writer = self._node.writer(self._states)
        self._readers = {mode: self._node.raw_reader(Topic(topic, COMMANDS)) for mode, topic in CONTROLLERS.values()}
        self._due = time.monotonic()

    def run(self, seconds: float) -> None:
        """Let real time pass."""
        ends = time.monotonic() + seconds
        while (now := time.monotonic()) < ends:
            for mode, reader in self._readers.items():
                for raw in reader.take()[-1:]:
                    self._obey(mode, raw)
            self.arm.step(STEP_S)
            self.steps += 1
            if self.telling:
                self._tell()
            self._due = max(self._due + STEP_S, now - BEHIND_S)
            ahead = self._due - time.monotonic()
            if ahead > 0:
                time.sleep(ahead)

    def _obey(self, mode: CommandMode, raw: bytes) -> None:
        message = message_of(raw, COMMANDS)
        if message is None or len(message.data) != len(self._names):
            return
        value = np.empty(len(self._names))
        value[self._of_order] = message.data
        self.commands += 1
        if mode is CommandMode.position:
            self.arm.servo(value, LOOKAHEAD_S)
        elif mode is CommandMode.velocity:
            self.arm.speed(value, ACCELERATION)
        else:
            self.arm.torque(value)

    def _tell(self) -> None:
        rows = self._of_order
        told = states_message(
            self._names, self.arm.position[rows], self.arm.velocity[rows], self.arm.moment[rows], time.time_ns()
        )
        self._writer.send(cdr(self._states, told))

    def tell(self, whether: bool) -> None:
        """Tell states, or tell none."""
        self.telling = whether

    def close(self) -> None:
        """End."""


def make(
    robot: str,
    domain: int,
    posture: Sequence[float] | None,
    joint_order: Sequence[str] | None,
    friction: float | None,
    carries_weight: bool,
) -> ForwardControllers:
    """In the process that shall run it."""
    model = robots.load(robot)
    at = gains_of(model).home if posture is None else posture
    order = joint_order or model.joint_names
    return ForwardControllers(model, at, domain, order, friction, carries_weight)


def forward_controllers(
    robot: str = "ur5",
    domain: int = 0,
    *,
    posture: Sequence[float] | None = None,
    joint_order: Sequence[str] | None = None,
    friction: float | None = None,
    carries_weight: bool = False,
) -> Process:
    """Start them on the loopback of this machine. Raises RehearsalError if they cannot be had.

    Args:
        robot: by name or URDF, n joints.
        domain: of ROS 2.
        posture: (n,) rad where it starts; by default the home of the robot's gains.
        joint_order: names of the joints, as the controllers have them; by default as the robot's model.
        friction: of the joints; see `UrArm`.
        carries_weight: the hardware adds the robot's weight to efforts.
    """
    return Process(
        make,
        robot=robot,
        domain=domain,
        posture=posture,
        joint_order=joint_order,
        friction=friction,
        carries_weight=carries_weight,
    )
