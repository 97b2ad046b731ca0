# SPDX-License-Identifier: Apache-2.0
"""What truly happens in a grasp with both arms, from the world: forces, falls, and changes without reason."""

from __future__ import annotations

from collections import deque
from collections.abc import Callable

import numpy as np
from numpy.typing import NDArray

from robotskin.apps.embrace.arms import SIDES
from robotskin.apps.embrace.grasp_control import GraspControl
from robotskin.apps.embrace.grasp_scene import THING
from robotskin.apps.embrace.grasp_states import GraspState
from robotskin.apps.embrace.pressed import BLOCKED, OUTSIDE, TOO_HARD
from robotskin.apps.embrace.regulation import BLOCKED_RAD
from robotskin.session import PERIOD_S, SafetyState, Session

TAP_N, TAP_S = 6.0, 1.0
FALL_M, TILT_RAD = 0.05, np.radians(20.0)
RECENT = 300
"""Steps: what was touched so long ago may still be felt."""
LEAST_N = 0.5
"""With less an area does not truly touch."""
SLIDE_PERIODS = 20
"""Between two looks at where the thing is."""
TRUE_SHARE = 0.8
"""Of a limit that a cell felt: with less it was not truly pressed so hard, since a sensor's gain is off by less."""
OPEN, CLOSE, PULL, HOME = GraspState.OPEN, GraspState.CLOSE, GraspState.PULL, GraspState.HOME


class GraspWatch:
    """What truly happens, from the world; the controller knows none of it."""

    def __init__(
        self, session: Session, control: GraspControl, look: Callable[[GraspWatch], None] = lambda _watch: None
    ) -> None:
        self.session, self.control, self._look = session, control, look
        self.thing = session.world.thing(THING)
        self.peak_arm_n = self.peak_cell_n = 0.0
        self.running = True
        self.transitions = self.false_transitions = 0
        """Changes of state, and those of them that what truly touched gave no reason for."""
        self._tapped = False
        self._recent: deque[dict[str, float]] = deque(maxlen=RECENT)
        self._pressed: deque[dict[str, float]] = deque(maxlen=RECENT)
        self._since = dict.fromkeys(control.arms.areas.cells, 0.0)
        self._states = 1
        self.slid_m = 0.0
        """How far at most the thing has moved between the forearms while it was held."""
        self._forearms = [session.robot.link_index(f"arm_{side}_5_link") for side in SIDES]
        self._held_at: NDArray[np.float64] | None = None
        self._ticks_home = 0

    def step(self) -> None:
        """One period of session, controller and watch."""
        self.session.step()
        self.control.step()
        self.running = self.running and self.session.state in (SafetyState.running, SafetyState.degraded)
        force = self.session.world.cell_true_force().sum(axis=1)
        areas = {area: float(force[cells].sum()) for area, cells in self.control.arms.areas.cells.items()}
        self.peak_cell_n = max(self.peak_cell_n, float(force.max()))
        self.peak_arm_n = max(self.peak_arm_n, *(areas[side] for side in SIDES))
        self._recent.append(areas)
        allowed = self.control.arms.areas.allowed
        largest = float(force[allowed].max()), float(force[~allowed].max(initial=0.0))
        self._pressed.append(dict(zip((TOO_HARD, OUTSIDE), largest, strict=True)))
        self._since = {area: max(self._since[area], areas[area]) for area in areas}
        if len(self.control.visited) > self._states:
            self._states = len(self.control.visited)
            self.transitions += 1
            self.false_transitions += not self._due(self.control.visited[-2], self.control.visited[-1])
            self._since = dict.fromkeys(areas, 0.0)
            self._tapped = False
        if self.control.state is HOME:
            self._slide()
        self._look(self)

    def _slide(self) -> None:
        """How far the thing has moved between the forearms since it is held."""
        self._ticks_home += 1
        if self._ticks_home % SLIDE_PERIODS:
            return
        links = self.session.robot.base_from_link(self.session.world.joint_positions())[self._forearms]
        place = self.thing.position_m - links[:, :3, 3].mean(axis=0)
        if self._held_at is None:
            self._held_at = place
        self.slid_m = max(self.slid_m, float(np.linalg.norm(place - self._held_at)))

    def run(self, seconds: float) -> None:
        """Step for a time."""
        for _ in range(round(seconds / PERIOD_S)):
            self.step()

    def tap_chest(self) -> None:
        """A hand touches the chest, above what is to be grasped, and leaves."""
        chest = self.control.arms.areas.cells["chest"]
        places = self.session.world.base_from_cell()[chest]
        self.session.world.push(int(chest[int(np.argmax(places[:, 2, 3]))]), TAP_N)
        self._tapped = True
        self.run(TAP_S)
        self.session.world.release()

    def fallen(self, height_m: float) -> bool:
        """Whether the thing has fallen from this height, or is tilted, by more than is allowed."""
        pose = self.thing.world_from_thing
        tilt = float(np.arccos(np.clip(pose[2, 2], -1.0, 1.0)))
        return bool(pose[2, 3] < height_m - FALL_M or tilt > TILT_RAD)

    def _due(self, before: GraspState, after: GraspState) -> bool:
        """Whether what truly touched, or did not, gave a reason for this change of state."""
        recent = {area: max(one[area] for one in self._recent) for area in self._since}
        lately = {area: min(one[area] for one in self._recent) for area in self._since}
        if before is OPEN:
            return self._tapped
        if (before, after) == (CLOSE, PULL):
            return all(self._since[side] > LEAST_N for side in SIDES)
        if after is HOME:
            return all(force > LEAST_N for force in recent.values())
        # Back to open: pressed wrongly; nothing, or one arm, or no chest; or what was held is lost.
        hold, because = self.control.arms.hold, self.control.because
        if because in (OUTSIDE, TOO_HARD):
            limit_n = hold.outside_n if because == OUTSIDE else hold.most_cell_n
            return max(one[because] for one in self._pressed) > TRUE_SHARE * limit_n
        if because == BLOCKED:
            astray = np.asarray(self.session.command.value) - self.session.world.joint_positions()
            return float(np.abs(astray[self.control.arms.arms.both]).max()) > TRUE_SHARE * BLOCKED_RAD
        held_n = hold.touch_n
        if before is CLOSE:
            return any(self._since[side] < held_n for side in SIDES)
        return lately["chest"] < held_n or all(force < held_n for force in lately.values())
