# SPDX-License-Identifier: Apache-2.0
"""The controller of a grasp with both arms: touch leads from state to state, and fits the taught paths to the thing."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from robotskin.apps.embrace.arms import SIDES, Around, Paths
from robotskin.apps.embrace.grasp_states import GraspSeen, GraspState, following_grasp
from robotskin.apps.embrace.regulation import LOOK_S, PERIODS, Hold, Regulation
from robotskin.apps.embrace.tap import Tap
from robotskin.session import SkinnedRobot

Array = NDArray[np.float64]

REACH_S = 1.5
FIRM_SHARE, FIRM_S = 0.6, 0.4
"""Both arms have felt this share of what they should, and the chest its touch, for so long."""
SLIP_SHARE, SLIP_LEAST_N, SLIP_LOOKS = 0.75, 4.0, 12
"""A slip: of so many newton less than this share is left in an area after so many looks."""
SLIP_GAIN, SLIP_MOST = 1.2, 1.6
GRASP_HOLD = Hold(
    arm_n=30.0,
    chest_n=15.0,
    cell_n=10.0,
    aside_m_s_n=0.0008,
    together_per_s=0.5,
    far_m=0.345,
    stiff_m=0.215,
    lean_rad=0.10,
)
"""Light enough for the arms' own torques, whose shoulders bear half of what they can by holding the arms up."""


GRASP_AROUND = Around(height_m=0.0, elbow_below_m=0.02, angle_deg=74.0, open_angle_deg=84.0, hand_rad=0.6)
"""Upper arms hang beside the thing, so that shoulders stay clear of it. Forearms turn inward, so that the near edges of
a wide box pass between the elbows; hands, which have no skin, turn outward, clear of its far edges."""


class GraspControl:
    """Grasps with the arms of a robot in its skin that runs; call `step` after each of its ticks.

    reactive: paths adapt to what the skin feels; False: they are gone through as they were taught for a thing of
    0.35 m. answers: touched cells give way, by the robot's sensory-motor map where it has one; False: the baseline
    whose paths alone adapt.
    """

    def __init__(
        self,
        session: SkinnedRobot,
        hold: Hold = GRASP_HOLD,
        around: Around | Paths | None = None,
        *,
        reactive: bool = True,
        answers: bool = True,
    ) -> None:
        self.session, self.reactive = session, reactive
        if isinstance(around, Paths):
            hold = replace(hold, lean_rad=0.0)  # the trunk is upright in a lesson
        self.arms = Regulation(session, hold, around or GRASP_AROUND, regulated=reactive, answers=answers)
        self.state, self.since_s, self.because = GraspState.OPEN, 0.0, ""
        self.slips = 0
        """How often a slip was felt and answered."""
        self.visited, self.reasons = [GraspState.OPEN], [""]
        """The states until now, and what led to each."""
        self._tick, self._firm_s = 0, 0.0
        self._tap, self._asked = Tap(LOOK_S), False
        self._begin: Array | None = np.array(session.home)
        """Where the arms come from when they open for the first time; later they go back as they came."""
        self._earlier: list[dict[str, float]] = []

    def ask(self) -> None:
        """Grasp, or open again, as after a touch on the chest."""
        self._asked = True

    def step(self) -> None:
        """One period of the session."""
        self._tick += 1
        if self._tick % PERIODS:
            return
        arms, before = self.arms, self.state
        arms.look()
        if before is GraspState.CLOSE:
            arms.meet()
        self._notice()
        self.state, because = following_grasp(before, self._seen())
        if self.state is before:
            self.since_s += LOOK_S
        else:
            self._enter(because)
        self._act()
        posture = arms.posture()
        if self.state is GraspState.OPEN and self._begin is not None:
            share = min(1.0, self.since_s / REACH_S)
            share = share * share * (3 - 2 * share)
            posture = (1 - share) * self._begin + share * posture
        arms.send(posture)

    def _notice(self) -> None:
        """Taps on the chest, firm holds and slips."""
        arms = self.arms
        if self.state is GraspState.OPEN:
            if "chest" in arms.lost_areas:  # a touch that ends because its cell dies asks for nothing
                self._tap = Tap(LOOK_S)
            arms.forget_lost()
            self._asked = self._tap.ends(arms.force["chest"]) or self._asked
        enough_n = FIRM_SHARE * arms.hold.arm_n * arms.eased()
        firm = all(arms.touches.values()) and arms.squeeze_n > enough_n
        self._firm_s = self._firm_s + LOOK_S if firm else 0.0
        if self.state is GraspState.HOME and self.reactive and self._slips():
            self.slips += 1
            arms.strength = min(SLIP_GAIN * arms.strength, SLIP_MOST)

    def _slips(self) -> bool:
        """Whether an area has lost a quarter of its force within 50 ms: what it held has slid under it."""
        now = dict(self.arms.force)
        self._earlier.append(now)
        if len(self._earlier) <= SLIP_LOOKS:
            return False
        before = self._earlier.pop(0)
        slid = any(before[area] > SLIP_LEAST_N and now[area] < SLIP_SHARE * before[area] for area in now)
        if slid:
            self._earlier.clear()
        return slid

    def _seen(self) -> GraspSeen:
        arms = self.arms
        return GraspSeen(
            since_s=self.since_s,
            reactive=self.reactive,
            open=arms.open and self.since_s >= REACH_S,
            closed=arms.closed,
            asked=self._asked,
            arms=all(arms.met[side] for side in SIDES),
            chest=arms.touches["chest"],
            firm=self._firm_s >= FIRM_S,
            lost=not any(arms.touches.values()),
            outside=arms.outside_n > arms.hold.outside_n,
            too_hard=arms.too_hard,
            blocked=arms.blocked,
            lost_areas=arms.lost_areas,
        )

    def _enter(self, because: str) -> None:
        self.since_s, self.because = 0.0, because
        self.visited.append(self.state)
        self.reasons.append(because)
        self._tap, self._asked = Tap(LOOK_S), False
        if self.state is GraspState.CLOSE:
            self.arms.begin()
            self.arms.strength = 1.0
        if self.state is GraspState.HOME:
            self._earlier.clear()
        if self.state is GraspState.OPEN:
            self._begin = None

    def _act(self) -> None:
        arms = self.arms
        if self.state is GraspState.OPEN:
            arms.part()
        elif not self.reactive:
            # Close where the thing is believed to be; then pull it as far as one of 0.35 m must come.
            arms.close_blindly(arms.hold.far_m if self.state is GraspState.CLOSE else TAUGHT_AXIS_M)
        elif self.state is GraspState.CLOSE:
            arms.close(pulling=False)
        elif self.state is GraspState.PULL:
            arms.close(pulling=True)
        else:
            arms.keep()


TAUGHT_AXIS_M = 0.27
"""Of a thing of 0.35 m at the chest."""
