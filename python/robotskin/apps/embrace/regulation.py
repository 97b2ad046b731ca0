# SPDX-License-Identifier: Apache-2.0
"""Both arms under the skin's command: where they lie about what they hold answers to what each area feels."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from robotskin.apps.embrace.areas import areas_of
from robotskin.apps.embrace.arms import SIDES, Arms, Around, Paths
from robotskin.apps.embrace.lost import LOST_SHARE
from robotskin.apps.embrace.tasks import use_embrace
from robotskin.session import PERIOD_S, LostCells, SkinnedRobot

Array = NDArray[np.float64]

PERIODS = 4
"""Of the session, between two looks: a cell samples every 4 to 8 ms."""
LOOK_S = PERIODS * PERIOD_S
OPEN_M, CLOSED_M, TIGHT_M = 0.35, 0.20, 0.10
"""Of the forearms from the axis: wide open, where skin weights are computed, and the end of their paths."""
CLOSED_AXIS_M, NEAR_M = 0.24, 0.165
"""Of the axis before the chest's joint: where a body of 0.25 m at the chest has it, and the end of the pull."""
SPEED_M_S, NEARBY_M_S, OPENING_M_S, PULL_M_S = 0.06, 0.025, 0.08, 0.04
FORCE_HZ = 5.0
"""Low-pass of the forces by which it regulates."""
_SLOW_SHARE = 1.0 - float(np.exp(-2 * np.pi * FORCE_HZ * LOOK_S))
HARD_S = 0.2
"""A cell that bears more than is allowed for longer ends the embrace."""
BLOCKED_RAD, BLOCKED_S = 0.02, 0.04
"""A closing arm with a joint that stays so far from its reference for so long is blocked. In free air joints stray by
3 mrad; later, what is held bends them as far."""
NEARBY_M = 0.04
"""A cell that sees something as near as this makes its arm slow."""
FIRM_SHARE = 0.8
"""Of the squeeze wanted: with it arms pull at full speed."""
PULL_PER_S, PULL_LEAST_M_S = 0.5, 0.012
"""What is pulled comes the slower the nearer the chest sees it: a heavy body at full speed would strike the chest with
speed times the root of mass and stiffness, 28 N for 75 kg and 7 kN/m."""


@dataclass(frozen=True)
class Hold:
    """How it holds: newton of an arm's cells together and of the chest's, of a touch, and of one cell.

    touch_n: at which an area counts as touching. cell_n: above it the arms give way. most_cell_n: above it they let go.
    outside_n: the same on cells where no contact is allowed. rate_m_s_n: how fast both arms close for a newton that
    they lack; aside_m_s_n: how fast they go aside for one by which they differ; pull_m_s_n: how fast the axis comes
    near for one that the chest lacks; together_per_s: how fast the arms come back to the same distance.
    compliance_share: see `use_embrace`. stiff_m: where arms that do not feel end, from the axis. far_m: where the axis
    is while the arms close. lean_rad: how far the trunk is bent forward.
    """

    arm_n: float = 34.0
    touch_n: float = 2.0
    cell_n: float = 11.0
    most_cell_n: float = 14.0
    outside_n: float = 8.0
    chest_n: float = 28.0
    rate_m_s_n: float = 0.0015
    aside_m_s_n: float = 0.009
    pull_m_s_n: float = 0.001
    together_per_s: float = 0.15
    compliance_share: float = 0.25
    stiff_m: float = 0.175
    far_m: float = 0.305
    lean_rad: float = 0.0


class Regulation:
    """What the areas of a robot's skin feel, and the references of its arms; the robot runs.

    regulated: the arms answer to the skin; False: they are stiff and go to the end of a path that they were taught.
    answers: arms that answer do so by the reaction of touched cells, too. around: how the arms lie, by the model, or
    the paths themselves, such as taught ones.
    """

    def __init__(
        self,
        session: SkinnedRobot,
        hold: Hold,
        around: Around | Paths,
        *,
        regulated: bool = True,
        answers: bool = True,
    ) -> None:
        self.session, self.hold, self.regulated = session, hold, regulated
        self.arms = Arms(session.robot, np.array(session.home), hold.lean_rad)
        self.paths = around if isinstance(around, Paths) else self.arms.plan(around)
        closed = self.arms.posture(self.paths, dict.fromkeys(SIDES, CLOSED_M), CLOSED_AXIS_M)
        self.areas = areas_of(self.arms, session.layout, closed, CLOSED_AXIS_M)
        self.radius = dict.fromkeys(SIDES, OPEN_M)
        """Metres between axis and forearm that each arm is told."""
        self.axis_m = hold.far_m
        """Metres of that axis before the chest's joint."""
        self.force = dict.fromkeys(self.areas.cells, 0.0)
        """Newton that the cells of each area feel together."""
        self.touches = dict.fromkeys(self.areas.cells, False)
        """Whether each area feels something now."""
        self.met = dict.fromkeys(SIDES, False)
        """Whether each arm has met something since it began to close."""
        self.largest_n = 0.0
        """Of one cell in the areas."""
        self.outside_n = 0.0
        """Of one cell outside of them."""
        self.touched: NDArray[np.bool_] = np.zeros(len(session.layout), dtype=bool)
        """(N,) cells that feel more than the gains' silence."""
        self.lost_areas: frozenset[str] = frozenset()
        """Those with a cell that felt something and is lost, or with more than `LOST_SHARE` of all their cells lost."""
        self._lost = LostCells(len(session.layout))
        self.strength = 1.0
        """By which slips have made the squeeze stronger."""
        self._middle = self.areas.middle_of_chest
        self._silent_n = float(session.gains.values["skin"]["force_silent_n"])
        self._allowed = self.areas.allowed
        self._slow = np.zeros(len(session.layout))
        self._hard_s = self._blocked_s = 0.0
        self._limits = (session.robot.lower + 1e-6, session.robot.upper - 1e-6)
        self.task = use_embrace(session, self._allowed, closed, hold.compliance_share, skin=regulated and answers)

    # ---- What it feels ----

    def look(self) -> None:
        """Take what the skin feels now."""
        cells = self.session.cell_forces_n()
        self.touched = cells > self._silent_n
        # What is left out and lives was left out on purpose. A page's health watch leaves out the dead by itself.
        self._lost.look(~self.session.living, self.touched)
        self.lost_areas = frozenset(area for area, own in self.areas.cells.items() if self._lost.among(own, LOST_SHARE))
        felt = np.where(self.touched, cells, 0.0)
        self.touches = {area: float(felt[own].sum()) >= self.hold.touch_n for area, own in self.areas.cells.items()}
        self._slow += _SLOW_SHARE * (felt - self._slow)
        self.force = {area: float(self._slow[own].sum()) for area, own in self.areas.cells.items()}
        self.largest_n = float(self._slow[self._allowed].max())
        self.outside_n = float(self._slow[~self._allowed].max(initial=0.0))
        self._hard_s = self._hard_s + LOOK_S if self.largest_n > self.hold.most_cell_n else 0.0
        astray = np.abs(np.asarray(self.session.command.value) - np.asarray(self.session.joints.position))[
            self.arms.both
        ]
        self._blocked_s = self._blocked_s + LOOK_S if float(astray.max()) > BLOCKED_RAD else 0.0

    def begin(self) -> None:
        """Arms that are open begin to close: none has met anything, and what lost cells once felt is over."""
        self.met = dict.fromkeys(SIDES, False)
        self.forget_lost()

    def forget_lost(self) -> None:
        """What lost cells felt counts no more; that too many are lost does."""
        self._lost.forget()

    def meet(self) -> None:
        """While arms close: an arm that meets something stops where it is.

        Its reference runs ahead of it; what it meets shall not be pressed until both agree.
        """
        for side in SIDES:
            if self.touches[side] and not self.met[side]:
                angles = np.array(self.session.joints.position)[self.arms.joints[side]]
                if self.regulated:
                    self.radius[side] = self.paths.radius_near(side, angles, self.radius[side], self.axis_m)
                self.met[side] = True

    @property
    def squeeze_n(self) -> float:
        """Newton by which both arms squeeze, the mean: what lies between them is pressed as hard from either side, and
        an arm that feels less bears the rest on bare parts."""
        return sum(self.force[side] for side in SIDES) / len(SIDES)

    @property
    def too_hard(self) -> bool:
        """Whether a cell has long borne more than is allowed."""
        return self._hard_s > HARD_S

    @property
    def blocked(self) -> bool:
        """Whether a joint of an arm has long been far from its reference, which is a position."""
        return self._blocked_s > BLOCKED_S

    @property
    def open(self) -> bool:
        """Whether both arms are told to be wide open."""
        return all(radius >= OPEN_M - 1e-6 for radius in self.radius.values())

    @property
    def closed(self) -> bool:
        """Whether both stiff arms are told to be at the end of their path."""
        return all(radius <= self.hold.stiff_m + 1e-6 for radius in self.radius.values())

    # ---- What it does ----

    def part(self) -> None:
        """A look's way towards open arms."""
        self.axis_m = min(self.axis_m + LOOK_S * PULL_M_S, self.hold.far_m)
        self._move(dict.fromkeys(SIDES, OPENING_M_S), TIGHT_M)

    def close_blindly(self, axis_m: float = CLOSED_AXIS_M) -> None:
        """A look's way of stiff arms."""
        self.axis_m = max(self.axis_m - LOOK_S * PULL_M_S, axis_m)
        self._move(dict.fromkeys(SIDES, -SPEED_M_S), self.hold.stiff_m)

    def close(self, *, pulling: bool) -> None:
        """A look's way of arms that come near, each until it meets something; then they wait, or pull."""
        speed = {side: self._speed(side) for side in SIDES}
        pull = -self._pull() * self._firmness() if pulling and not self.touches["chest"] else 0.0
        self.axis_m = float(np.clip(self.axis_m + LOOK_S * pull, NEAR_M, self.hold.far_m))
        self._move(speed, TIGHT_M)

    def keep(self) -> None:
        """A look's way of arms that hold what is at the chest."""
        speed = {side: self._speed(side) for side in SIDES}
        lacks = self.strength * self.hold.chest_n * self.eased() - self.force["chest"]
        pull = float(np.clip(-self.hold.pull_m_s_n * lacks, -PULL_M_S, PULL_M_S))
        self.axis_m = float(np.clip(self.axis_m + LOOK_S * pull, NEAR_M, self.hold.far_m))
        self._move(speed, TIGHT_M)

    def posture(self) -> Array:
        """(n) rad that the references ask for."""
        return self.arms.posture(self.paths, self.radius, self.axis_m)

    def send(self, posture: Array) -> None:
        """Give (n) rad to the robot."""
        self.task.request_reference(np.clip(posture, *self._limits))

    def _move(self, speed: dict[str, float], least_m: float) -> None:
        for side in SIDES:
            self.radius[side] = float(np.clip(self.radius[side] + LOOK_S * speed[side], least_m, OPEN_M))

    def eased(self) -> float:
        """Share of the forces wanted: one cell that bears much makes all give way before it comes to its limit."""
        hold = self.hold
        return float(np.clip((hold.most_cell_n - self.largest_n) / (hold.most_cell_n - hold.cell_n), 0.0, 1.0))

    def _pull(self) -> float:
        """m/s towards the chest, of what has not reached it."""
        if not self.session.fresh[self._middle].any():  # it sees nothing because it is blind
            return PULL_LEAST_M_S
        near = float(self.session.cell_distances_m()[self._middle].min())
        return float(np.clip(PULL_PER_S * near, PULL_LEAST_M_S, PULL_M_S))

    def _firmness(self) -> float:
        """Share of the full pull that the squeeze allows: arms that squeeze less slide along the thing."""
        enough_n = FIRM_SHARE * self.strength * self.hold.arm_n * self.eased()
        return float(np.clip(self.squeeze_n / max(enough_n, 1e-9), 0.0, 1.0))

    def _speed(self, side: str) -> float:
        """m/s away from the axis, of an arm that answers to the skin."""
        other = next(one for one in SIDES if one != side)
        if not self.met[side]:
            near = float(self.session.cell_distances_m()[self.areas.cells[side]].min())
            return -(NEARBY_M_S if near < NEARBY_M else SPEED_M_S)
        if not self.met[other]:  # waits for the other
            speed = self.hold.rate_m_s_n * (self.force[side] - 2 * self.hold.touch_n)
            return float(np.clip(speed, -SPEED_M_S, SPEED_M_S))
        both = (self.force[side] + self.force[other]) / 2
        speed = self.hold.rate_m_s_n * (both - self.strength * self.hold.arm_n * self.eased())
        speed += self.hold.aside_m_s_n * (self.force[side] - both)
        speed += self.hold.together_per_s * (self.radius[other] - self.radius[side]) / 2
        return float(np.clip(speed, -SPEED_M_S, SPEED_M_S))
