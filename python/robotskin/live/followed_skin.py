# SPDX-License-Identifier: Apache-2.0
"""Another robot's skin as of now, for the page: what a fleet's follower shows, and how fresh it is."""

from __future__ import annotations

import time
from collections.abc import Mapping, Sequence
from dataclasses import replace
from typing import Any

import numpy as np

from robotskin.fleet.followed import FollowedRobot
from robotskin.layout import Layout
from robotskin.record import Frame
from robotskin.robots import Robot
from robotskin.sharing.follower import Show
from robotskin.skin import Health
from robotskin.viewer.session_view import Floats, SkinReading

__all__ = ["FollowedSkin"]

STALE_S = 1.0
"""Without a moment for so long, nothing of it is of now."""


class FollowedSkin:
    """A `Show` of a followed robot, and a `robotskin.viewer.followed_page.FollowedView`."""

    period_s = 1 / 30

    def __init__(self, followed: FollowedRobot, also: Sequence[Show] = ()) -> None:
        """`also`: further shows of the same robot."""
        self.robot: Robot = followed.robot
        self.layout: Layout = followed.layout
        self.posture: Floats = followed.robot.neutral
        self._followed = followed
        self._reading: SkinReading | None = None
        self._heard_s = time.monotonic()
        followed.begin([self, *also])

    # ---- The follower's thread ----

    def show(self, frame: Frame, stamp_ns: int) -> None:
        """A moment."""
        if len(frame.position) == self.robot.joint_count and np.isfinite(frame.position).all():
            self.posture = np.array(frame.position)
        self._reading = SkinReading.of(frame.skin, frame.time_ns)
        self._heard_s = time.monotonic()

    def tell_network(self, topology: Mapping[str, Any], statistics: Mapping[str, int], stamp_ns: int) -> None:
        """Not shown."""

    def close(self) -> None:
        """The page closes itself."""

    # ---- Any thread ----

    def reading(self) -> SkinReading | None:
        """What was felt last; where that is not fresh, no cell is alive."""
        reading, silent_s = self._reading, time.monotonic() - self._heard_s
        if reading is None or silent_s < STALE_S:
            return reading
        health = np.where(reading.health == int(Health.alive), int(Health.stale), reading.health)
        return replace(reading, health=health, age_s=reading.age_s + silent_s)

    def told(self) -> str:
        """Whether the link lives."""
        followed, silent_s = self._followed, time.monotonic() - self._heard_s
        if followed.ended or followed.failure is not None:
            return followed.ended or f"nothing more can be shown: {followed.failure}"
        lost = f"; {followed.missed} messages are lost for good" if followed.missed else ""
        if self._reading is None:
            return f"waiting for {followed.name}"
        if silent_s >= STALE_S:
            return f"nothing heard from {followed.name} for {silent_s:.0f} s: the skin is as it was then{lost}"
        return f"live from {followed.name}{lost}"
