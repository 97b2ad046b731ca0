# SPDX-License-Identifier: Apache-2.0
"""The controller of a hug: looks at the skin at its own rate, and goes through the states."""

from __future__ import annotations

import numpy as np

from robotskin.apps.embrace.arms import SIDES, Around
from robotskin.apps.embrace.regulation import LOOK_S, OPEN_M, PERIODS, Hold, Regulation
from robotskin.apps.embrace.states import Seen, State, following
from robotskin.session import SkinnedRobot

REACH_S = 2.0
"""From the posture before to the open arms."""


class HugControl:
    """Hugs with the arms of a robot in its skin that runs; call `step` after each of its ticks.

    regulated: the arms answer to the skin; False: stiff arms that go to the end of a path that they were taught.
    """

    def __init__(
        self, session: SkinnedRobot, hold: Hold | None = None, around: Around | None = None, *, regulated: bool = True
    ) -> None:
        self.session = session
        self.arms = Regulation(session, hold or Hold(), around or Around(), regulated=regulated)
        self.state, self.since_s, self.because = State.OPEN, 0.0, ""
        self._asked_to_release = False
        self._tick = 0
        self._begin = np.array(session.home)

    def release(self) -> None:
        """Let go."""
        self._asked_to_release = True

    def restart(self) -> None:
        """Hug again."""
        self._asked_to_release = False
        self._begin = self.arms.posture()
        self.state, self.since_s = State.OPEN, 0.0
        self.arms.radius, self.arms.axis_m = dict.fromkeys(SIDES, OPEN_M), self.arms.hold.far_m

    def step(self) -> None:
        """One period of the session."""
        self._tick += 1
        if self._tick % PERIODS:
            return
        arms, before = self.arms, self.state
        arms.look()
        if self.state is State.CLOSE:
            arms.meet()
        self.state, because = following(before, self._seen())
        if self.state is before:
            self.since_s += LOOK_S
        else:
            self.since_s, self.because = 0.0, because
            if self.state is State.CLOSE:
                arms.begin()
        if self.state in (State.RELEASE, State.RELEASED):
            arms.part()
        elif self.state in (State.CLOSE, State.HOLD) and not arms.regulated:
            arms.close_blindly()
        elif self.state is State.CLOSE:
            arms.close(pulling=True)
        elif self.state is State.HOLD:
            arms.keep()
        posture = arms.posture()
        if self.state is State.OPEN:
            share = min(1.0, self.since_s / REACH_S)
            share = share * share * (3 - 2 * share)
            posture = (1 - share) * self._begin + share * posture
        arms.send(posture)

    def _seen(self) -> Seen:
        arms = self.arms
        return Seen(
            since_s=self.since_s,
            regulated=arms.regulated,
            open=arms.open and (self.state is not State.OPEN or self.since_s >= REACH_S),
            closed=arms.closed,
            arms=all(arms.touches[side] for side in SIDES),
            chest=arms.touches["chest"],
            outside=arms.outside_n > arms.hold.outside_n,
            too_hard=arms.too_hard,
            lost_areas=arms.lost_areas,
            asked_to_release=self._asked_to_release,
        )
