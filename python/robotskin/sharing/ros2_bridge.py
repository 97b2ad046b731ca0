# SPDX-License-Identifier: Apache-2.0
"""A running skin on topics of ROS 2, without ROS."""

from __future__ import annotations

import time
from collections.abc import Mapping, Sequence
from typing import Any

from robotskin.layout import Layout
from robotskin.record import Frame
from robotskin.robots import Robot
from robotskin.ros2 import Topic
from robotskin.ros2.dds import DdsNode
from robotskin.ros2.message_types import cdr
from robotskin.sharing import ROS2_DOMAIN
from robotskin.sharing.ros2_messages import TOPICS, Ros2Messages

PERIOD_S = 0.004
LOOKED_AT_S = 0.02
"""Between frames, point clouds and contacts."""


class Ros2Bridge:
    """Publishes what a follower shows, until `close`.

    Args:
        robot, layout: of the skin. domain: of ROS 2. interface: of a network; None: this machine alone, no multicast.
        untold: topics that others tell.

    Raises:
        Ros2Error: no such domain or interface.
    """

    def __init__(
        self,
        robot: Robot,
        layout: Layout,
        domain: int = ROS2_DOMAIN,
        interface: str | None = None,
        untold: Sequence[Topic] = (),
    ) -> None:
        self.period_s = PERIOD_S
        self.sent = 0
        """Packed skin states sent so far."""
        self.node = DdsNode(domain, interface)
        self._messages = Ros2Messages(robot, layout)
        self._writers = {topic: self.node.writer(topic) for topic in TOPICS if topic not in untold}
        self._due_ns = 0
        for topic, message in self._messages.once(time.time_ns()):
            self._send(topic, message)
        where = "127.0.0.1 without multicast" if interface is None else interface
        self.told = f"ROS 2: domain {domain} on {where}; topics {', '.join(topic.name for topic in self._writers)}"
        """What a user is told."""

    @property
    def readers(self) -> dict[str, int]:
        """How many listen to each topic; what is sent before a listener is known never reaches it."""
        return {topic.name: writer.readers for topic, writer in self._writers.items()}

    def show(self, frame: Frame, stamp_ns: int) -> None:
        """A moment, and its time in nanoseconds since 1970."""
        for topic, message in self._messages.at_each_moment(frame, stamp_ns):
            self._send(topic, message)
        self.sent += 1
        if stamp_ns < self._due_ns:
            return
        self._due_ns = max(self._due_ns, stamp_ns) + round(1e9 * LOOKED_AT_S)
        for topic, message in self._messages.now_and_then(frame, stamp_ns):
            self._send(topic, message)

    def _send(self, topic: Topic, message: Any) -> None:
        writer = self._writers.get(topic)
        if writer is not None:
            writer.send(cdr(topic, message))

    def tell_network(self, topology: Mapping[str, Any], statistics: Mapping[str, int], stamp_ns: int) -> None:
        """The network is not told: no message of ROS 2 has it."""

    def close(self) -> None:
        """End: the topics are gone with their writers."""
        self._writers.clear()
