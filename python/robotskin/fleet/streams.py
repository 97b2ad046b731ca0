# SPDX-License-Identifier: Apache-2.0
"""Numbered messages from one robot to all that listen; what a broken link loses is fetched from the robot's cache."""

from __future__ import annotations

from collections.abc import Callable

import zenoh
from zenoh import ext

from robotskin.fleet.errors import FleetError
from robotskin.fleet.messages import NUMBER, number_of

BATCH_S = 0.02
"""Between two messages of a stream."""
CACHED = 1000
"""Messages that a robot keeps for those that missed them: the last 20 s at least."""
HEARTBEAT_S = 0.2
"""In which the number of the last message is told again, so that a loss at the end shows."""


class Stream:
    """The robot's end."""

    def __init__(self, link: zenoh.Session, key: str, run: int) -> None:
        replies = ext.RepliesConfig(congestion_control=zenoh.CongestionControl.BLOCK)
        self._run = run
        self.number = 0
        """Of the next message."""
        self._publisher = ext.declare_advanced_publisher(
            link,
            key,
            cache=ext.CacheConfig(CACHED, replies_config=replies),
            sample_miss_detection=ext.MissDetectionConfig(heartbeat=HEARTBEAT_S, sporadic_heartbeat=None),
            publisher_detection=True,
        )

    def put(self, payload: bytes) -> None:
        """Send a message, and keep it. Without a link it is only kept."""
        self._publisher.put(payload, attachment=NUMBER.pack(self._run, self.number))
        self.number += 1

    def skip(self) -> None:
        """A message will never come: its number is not used, so that listeners know."""
        self.number += 1

    def close(self) -> None:
        """No more will come."""
        self._publisher.undeclare()


class Heard:
    """A listener's end: every message once and in order, from those that the robot still keeps.

    Args:
        take: hears (run, payload). miss: hears how many were lost for good, before the message that follows them.
        Both are called in a thread of Zenoh.
    """

    def __init__(
        self,
        link: zenoh.Session,
        key: str,
        take: Callable[[int, bytes], None],
        miss: Callable[[int], None] = lambda count: None,
    ) -> None:
        self.missed = 0
        """Lost for good so far."""
        self.refused = 0
        """Messages that fitted no stream."""
        self._take, self._miss = take, miss
        self._run, self._next = -1, 0
        self._subscriber = ext.declare_advanced_subscriber(
            link,
            key,
            self._heard,
            history=ext.HistoryConfig(detect_late_publishers=True),
            recovery=ext.RecoveryConfig(heartbeat=True, periodic_queries=None),
        )

    def _heard(self, sample: zenoh.Sample) -> None:
        try:
            run, number = number_of(None if sample.attachment is None else sample.attachment.to_bytes())
        except FleetError:
            self.refused += 1
            return
        if run != self._run:
            self._run, self._next = run, number  # what was before is no loss: the listener, or the robot, is new
        elif number < self._next:
            return
        elif number > self._next:
            self.missed += number - self._next
            self._miss(number - self._next)
        self._next = number + 1
        self._take(run, sample.payload.to_bytes())

    def close(self) -> None:
        """Hear no more."""
        self._subscriber.undeclare()
