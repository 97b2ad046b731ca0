# SPDX-License-Identifier: Apache-2.0
"""Where the joints are that a domain of ROS 2 tells on this machine."""

from __future__ import annotations

import time

import numpy as np
from numpy.typing import NDArray

from robotskin.rehearsal.process import RehearsalError
from robotskin.robots import Robot
from robotskin.ros2.dds import DdsNode
from robotskin.ros2.joint_messages import STATES, JointOrder, message_of
from robotskin.ros2.topic import Topic


class Ros2JointWatch:
    """The newest joint positions; `look` never waits. Raises RehearsalError if nothing tells them at first."""

    def __init__(self, domain: int, robot: Robot, within_s: float = 20.0) -> None:
        self._node = DdsNode(domain)
        self._reader = self._node.raw_reader(Topic("/joint_states", STATES))
        self._order = JointOrder(robot.joint_names)
        self._position: NDArray[np.float64] | None = None
        ends = time.monotonic() + within_s
        while self._position is None:
            if time.monotonic() > ends:
                raise RehearsalError(f"ROS 2 domain {domain}: nothing tells the joints of {robot.name}")
            self._reader.wait(0.05)
            self._take()

    def _take(self) -> None:
        for raw in self._reader.take()[-1:]:
            message = message_of(raw, STATES)
            heard = None if message is None else self._order.heard(message)
            if heard is not None:
                self._position = heard.position

    def look(self) -> NDArray[np.float64]:
        """(n,) rad; the last ones known."""
        self._take()
        assert self._position is not None
        return self._position

    def close(self) -> None:
        """Look no more."""
        self._reader.close()
