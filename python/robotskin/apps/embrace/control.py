# SPDX-License-Identifier: Apache-2.0
"""The controller of a hug: looks at the skin at its own rate, goes through the states, and moves the arms' references."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from robotskin.apps.embrace.areas import areas_of
from robotskin.apps.embrace.arms import SIDES, Around, Arms
from robotskin.apps.embrace.states import Seen, State, following
from robotskin.apps.embrace.tasks import use_embrace
from robotskin.session import PERIOD_S, SkinnedRobot

Array = NDArray[np.float64]

PERIODS = 4
"""Of the session, between two looks: a cell samples every 4 to 8 ms."""
LOOK_S = PERIODS * PERIOD_S
OPEN_M, CLOSED_M, TIGHT_M = 0.34, 0.20, 0.10
"""Of the forearms from the axis: wide open, where skin weights are computed, and the end of their paths."""
FAR_M, CLOSED_AXIS_M, NEAR_M = 0.29, 0.225, 0.15
"""Of the axis before the base: where arms close, where a person at the chest has it, and the end of the pull."""
SPEED_M_S, NEARBY_M_S, OPENING_M_S, PULL_M_S = 0.06, 0.025, 0.08, 0.04
HARD_S = 0.2
"""A cell that bears more than is allowed for longer ends the hug."""
NEARBY_M = 0.04
"""A cell that sees something as near as this makes its arm slow."""
REACH_S = 2.0
"""From the posture before to the open arms."""
TOGETHER_PER_S = 0.15
"""How fast the arms come back to the same distance while a push has moved what they hold."""


@dataclass(frozen=True)
class Hold:
    """How it hugs: newton of an arm's cells together and of the chest's, of a touch, and of one cell.

    touch_n: at which an arm or the chest counts as touching. cell_n: above it the arms give way. most_cell_n: above it
    they let go. outside_n: the same on cells where no contact is allowed. rate_m_s_n: how fast both arms
    close for a newton that they lack; aside_m_s_n: how fast they go aside for one by which they differ; pull_m_s_n: how
    fast the axis comes near for one that the chest lacks. compliance_share: see `use_embrace`. stiff_m: where stiff arms end, from the axis.
    """

    arm_n: float = 25.0
    touch_n: float = 2.0
    cell_n: float = 10.0
    most_cell_n: float = 14.0
    outside_n: float = 8.0
    chest_n: float = 20.0
    rate_m_s_n: float = 0.0015
    aside_m_s_n: float = 0.0006
    pull_m_s_n: float = 0.001
    compliance_share: float = 0.25
    stiff_m: float = 0.175


class HugControl:
    """Hugs with the arms of a robot in its skin that runs; call `step` after each of its ticks.

    regulated: the arms answer to the skin; False: stiff arms that go to the end of a path that they were taught.
    """

    def __init__(
        self, session: SkinnedRobot, hold: Hold | None = None, around: Around | None = None, *, regulated: bool = True
    ) -> None:
        self.session, self.hold, self.around = session, hold or Hold(), around or Around()
        self.regulated = regulated
        self.arms = Arms(session.robot, np.array(session.home))
        self.paths = self.arms.plan(self.around)
        closed = self.arms.posture(self.paths, dict.fromkeys(SIDES, CLOSED_M), CLOSED_AXIS_M)
        self.areas = areas_of(session.robot, session.layout, closed, CLOSED_AXIS_M)
        self.state, self.since_s, self.because = State.OPEN, 0.0, ""
        self.radius = dict.fromkeys(SIDES, OPEN_M)
        """Metres between axis and forearm that each arm is told."""
        self.axis_m = FAR_M
        """Metres of that axis before the base."""
        self.touches = dict.fromkeys(self.areas.cells, False)
        """Whether each area feels something now."""
        self.met = dict.fromkeys(SIDES, False)
        """Whether each arm has met something since it began to close."""
        self.force = dict.fromkeys(self.areas.cells, 0.0)
        """Newton that the cells of each area feel together."""
        self.largest_n = 0.0
        """Of one cell in the areas."""
        self.outside_n = 0.0
        """Of one cell outside of them."""
        self.touched: NDArray[np.bool_] = np.zeros(len(session.layout), dtype=bool)
        """(N,) cells that feel more than the gains' silence."""
        self._silent_n = float(session.gains.values["skin"]["force_silent_n"])
        self._allowed = self.areas.allowed
        self._asked_to_release = False
        self._tick, self._hard_s = 0, 0.0
        self._begin = np.array(session.home)
        self._limits = (session.robot.lower + 1e-6, session.robot.upper - 1e-6)
        self.task = use_embrace(session, self._allowed, closed, self.hold.compliance_share, skin=regulated)

    def release(self) -> None:
        """Let go."""
        self._asked_to_release = True

    def restart(self) -> None:
        """Hug again."""
        self._asked_to_release = False
        self._begin = self.arms.posture(self.paths, self.radius, self.axis_m)
        self.state, self.since_s = State.OPEN, 0.0
        self.radius, self.axis_m = dict.fromkeys(SIDES, OPEN_M), FAR_M

    def step(self) -> None:
        """One period of the session."""
        self._tick += 1
        if self._tick % PERIODS:
            return
        self._look()
        before = self.state
        self.state, because = following(before, self._seen())
        if self.state is before:
            self.since_s += LOOK_S
        else:
            self.since_s, self.because = 0.0, because
            if self.state is State.CLOSE:
                self.met = dict.fromkeys(SIDES, False)
        self._act()
        self._send()

    def _look(self) -> None:
        cells = np.asarray(self.session.skin.normal_force).sum(axis=1)
        self.touched = cells > self._silent_n
        felt = np.where(self.touched, cells, 0.0)
        self.force = {area: float(felt[own].sum()) for area, own in self.areas.cells.items()}
        self.touches = {area: force >= self.hold.touch_n for area, force in self.force.items()}
        if self.state is not State.CLOSE:
            return
        for side in SIDES:
            if self.touches[side] and not self.met[side]:
                # The reference runs ahead of the arm; what it meets shall not be pressed until both agree.
                angles = np.array(self.session.joints.position)[self.arms.joints[side]]
                if self.regulated:
                    self.radius[side] = self.paths.radius_near(side, angles, self.radius[side], self.axis_m)
                self.met[side] = True
        self.largest_n = float(felt[self._allowed].max())
        self.outside_n = float(felt[~self._allowed].max(initial=0.0))
        self._hard_s = self._hard_s + LOOK_S if self.largest_n > self.hold.most_cell_n else 0.0

    def _seen(self) -> Seen:
        return Seen(
            since_s=self.since_s,
            regulated=self.regulated,
            open=all(radius >= OPEN_M - 1e-6 for radius in self.radius.values())
            and (self.state is not State.OPEN or self.since_s >= REACH_S),
            closed=all(radius <= self.hold.stiff_m + 1e-6 for radius in self.radius.values()),
            arms=all(self.touches[side] for side in SIDES),
            chest=self.touches["chest"],
            outside=self.outside_n > self.hold.outside_n,
            too_hard=self._hard_s > HARD_S,
            asked_to_release=self._asked_to_release,
        )

    def _act(self) -> None:
        least = TIGHT_M if self.regulated else self.hold.stiff_m
        if self.state in (State.RELEASE, State.RELEASED):
            speed = dict.fromkeys(SIDES, OPENING_M_S)
            self.axis_m = min(self.axis_m + LOOK_S * PULL_M_S, FAR_M)
        elif self.state not in (State.CLOSE, State.HOLD):
            return
        elif not self.regulated:
            speed = dict.fromkeys(SIDES, -SPEED_M_S)
            self.axis_m = max(self.axis_m - LOOK_S * PULL_M_S, CLOSED_AXIS_M)
        else:
            speed = {side: self._speed(side) for side in SIDES}
            self.axis_m = float(np.clip(self.axis_m + LOOK_S * self._pull(), NEAR_M, FAR_M))
        for side in SIDES:
            self.radius[side] = float(np.clip(self.radius[side] + LOOK_S * speed[side], least, OPEN_M))

    def _eased(self) -> float:
        """Share of the forces wanted: one cell that bears much makes all give way before it comes to its limit."""
        hold = self.hold
        return float(np.clip((hold.most_cell_n - self.largest_n) / (hold.most_cell_n - hold.cell_n), 0.0, 1.0))

    def _speed(self, side: str) -> float:
        """m/s away from the axis, of an arm that answers to the skin."""
        other = next(one for one in SIDES if one != side)
        if not self.met[side]:
            near = float(np.asarray(self.session.skin.distance)[self.areas.cells[side]].min())
            return -(NEARBY_M_S if near < NEARBY_M else SPEED_M_S)
        if not self.met[other]:  # waits for the other
            speed = self.hold.rate_m_s_n * (self.force[side] - 2 * self.hold.touch_n)
            return float(np.clip(speed, -SPEED_M_S, SPEED_M_S))
        both = (self.force[side] + self.force[other]) / 2
        speed = self.hold.rate_m_s_n * (both - self.hold.arm_n * self._eased())
        speed += self.hold.aside_m_s_n * (self.force[side] - both)
        speed += TOGETHER_PER_S * (self.radius[other] - self.radius[side]) / 2
        return float(np.clip(speed, -SPEED_M_S, SPEED_M_S))

    def _pull(self) -> float:
        """m/s of the axis away from the chest."""
        if self.state is State.CLOSE:
            return -PULL_M_S if all(self.met.values()) and not self.touches["chest"] else 0.0
        speed = self.hold.pull_m_s_n * (self.force["chest"] - self.hold.chest_n * self._eased())
        return float(np.clip(speed, -PULL_M_S, PULL_M_S))

    def _send(self) -> None:
        posture = self.arms.posture(self.paths, self.radius, self.axis_m)
        if self.state is State.OPEN:
            share = min(1.0, self.since_s / REACH_S)
            share = share * share * (3 - 2 * share)
            posture = (1 - share) * self._begin + share * posture
        self.task.request_reference(np.clip(posture, *self._limits))
