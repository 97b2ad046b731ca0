# SPDX-License-Identifier: Apache-2.0
"""A robot at work with its gripper: moves smoothly, closes by force, gives way to people, and knows its pads."""

from __future__ import annotations

from collections.abc import Generator
from typing import Any

import numpy as np
from numpy.typing import NDArray

from robotskin.control import Behaviour
from robotskin.errors import RobotskinError
from robotskin.session import PERIOD_S, LostCells, Session
from robotskin.teaching.behaviours import WORK, use
from robotskin.teaching.gripper import Gripper
from robotskin.teaching.postures import Postures

Array = NDArray[np.float64]
Steps = Generator[None, None, Any]
"""A skill: goes on by one look at each `next`, and returns what it found."""

PERIODS = 4
"""Of the session, between two looks: a cell samples every 4 ms."""
LOOK_S = PERIODS * PERIOD_S
SPEED_M_S, LEAST_MOVE_S = 0.20, 0.4
PAD_SPEED_M_S = 0.05
END_M = 0.004
"""From the end of a pad's way: nearer to it the guard slows the pad, and the servo's correction winds up."""
TURN_RAD_S = 0.9
FLOOR_N = 0.15
"""What a cell may read with nothing on it."""
LOST_SHARE = 0.5
"""Of a pad's cells: where more are lost, it does not know how hard it presses, whether they felt something or not."""
CARRIES_SHARE = 0.08
"""A cell with less of its pad's force does not count."""
GIVE_M_S_N, FASTEST_GIVE_M_S = 0.0012, 0.006
"""How fast a pad moves for a newton that is lacking, and at most."""


class Worker:
    """What a session that has booted does with its gripper; call `step` after each of the session's steps.

    The joints follow a reference that leads by what the virtual robot's friction lets them lag. The pads' cells feel
    things and move nothing; the arm's cells feel people and make the arm give way.
    """

    def __init__(self, session: Session) -> None:
        self.session = session
        self.gripper = Gripper(session.robot, session.layout)
        self.postures = Postures(session.robot, self.gripper, np.asarray(session.home))
        self._tick = 0
        self._skill: Steps | None = None
        self._tare, self.force_n = np.zeros(2), np.zeros(2)
        self.hold_n: float | None = None
        """Newton with which the pads hold, whatever else is done; None: they stay where they are."""
        self._lost = LostCells(len(session.layout))
        self.lost: NDArray[np.bool_] = np.zeros(2, dtype=bool)
        """(2,) pads with a lost cell that felt something, or with too few that are heard: they press no harder."""
        self.result: Any = None
        """What the last skill returned."""
        self._lag_s = float(session.gains.values["virtual_robot"]["friction_s"])
        self.wanted = np.array(session.joints.position)
        """(n) where the joints are to be at this moment."""
        self._before = self.wanted.copy()
        self.use(WORK)

    def use(self, behaviour: Behaviour) -> None:
        """Follow references by this behaviour from now on, from where the robot is."""
        robot = self.session.robot
        self.wanted = np.clip(np.array(self.session.joints.position), robot.lower, robot.upper)
        self._before = self.wanted.copy()
        self._task = use(self.session, behaviour)
        for patch in self.gripper.patches:
            self.session.mask_patch(patch, True)

    # ---- Time ----

    def begin(self, skill: Steps) -> None:
        """Do this from the next look on."""
        self._skill, self.result = skill, None

    @property
    def busy(self) -> bool:
        """Whether a skill is under way."""
        return self._skill is not None

    @property
    def looks_next(self) -> bool:
        """Whether the next step is a look."""
        return (self._tick + 1) % PERIODS == 0

    def step(self) -> None:
        """One period of the session.

        Raises what a skill raises, such as TeachingError for a place out of reach: the arm stays where it is then.
        """
        self._tick += 1
        if self._tick % PERIODS:
            return
        self._lost.look(~self.session.fresh, self.session.cell_forces_n() > FLOOR_N)
        self.lost = np.array([self._lost.among(pad, LOST_SHARE) for pad in self.gripper.cells])
        self.force_n = self.gripper.forces_n(self.session) - self._tare
        if self._skill is not None:
            try:
                next(self._skill)
            except StopIteration as end:
                self._skill, self.result = None, end.value
            except RobotskinError:
                self._skill = None
                self.stay()
                raise
        self._send()

    def run(self, skill: Steps) -> Any:
        """Carry a skill out while the session steps; returns what it found."""
        self.begin(skill)
        while self.busy:
            self.session.step()
            self.step()
        return self.result

    def _send(self) -> None:
        robot = self.session.robot
        velocity = (self.wanted - self._before) / LOOK_S
        self._before = self.wanted.copy()
        if self.hold_n is not None and not self.lost.any():
            # From where the pads are: an integral would wind up against their friction.
            pads = self.gripper.joints
            lacks = self.hold_n - float(self.force_n.mean())
            self.wanted[pads] = self._before[pads] = self.openings_m
            velocity[pads] = -np.clip(GIVE_M_S_N * lacks, -FASTEST_GIVE_M_S, FASTEST_GIVE_M_S)
        reference = np.clip(self.wanted + self._lag_s * velocity, robot.lower, robot.upper)
        self._task.request_reference(reference)

    # ---- What it feels ----

    @property
    def now_s(self) -> float:
        """Virtual time."""
        return self.session.world.time_s

    @property
    def openings_m(self) -> Array:
        """(2,) of the pads, as measured."""
        return self.gripper.opening_m(self.session)

    @property
    def place_m(self) -> Array:
        """(3,) base frame, of the pads' middle, as measured."""
        return self.postures.place_of(np.array(self.session.joints.position))

    def has_lost(self, cells: NDArray[np.int64]) -> bool:
        """Whether one of these cells that felt something is lost."""
        return self._lost.among(cells)

    def carrying(self) -> tuple[int, int]:
        """How many cells of each pad carry a part of its force that counts; offsets are not taken out."""
        force = self.session.cell_forces_n()
        left, right = (np.maximum(force[cells] - FLOOR_N, 0.0) for cells in self.gripper.cells)
        return _carrying(left), _carrying(right)

    # ---- Parts of skills ----

    def wait(self, seconds: float) -> Steps:
        """Stay."""
        for _ in range(max(round(seconds / LOOK_S), 1)):
            yield

    def tare(self) -> Steps:
        """Take what the pads feel with nothing between them for zero."""
        total, looks = np.zeros(2), 25
        for _ in range(looks):
            total += self.gripper.forces_n(self.session)
            yield
        self._tare = total / looks

    def move_to(self, place_m: Array, speed_m_s: float = SPEED_M_S) -> Steps:
        """Bring the pads' middle to a place, (3) metres in the base frame, on a smooth way through the joints."""
        begin = self.wanted.copy()
        goal = self.postures.at(np.asarray(place_m, dtype=float), begin)
        way = float(np.linalg.norm(place_m - self.postures.place_of(begin)))
        turn = float(np.abs(goal - begin)[self.gripper.arm].max())
        lasts_s = max(1.9 * way / speed_m_s, 1.9 * turn / TURN_RAD_S, LEAST_MOVE_S)
        arm = self.gripper.arm
        for look in range(1, round(lasts_s / LOOK_S) + 1):
            t = min(look * LOOK_S / lasts_s, 1.0)
            share = t**3 * (10 - 15 * t + 6 * t * t)
            self.wanted[arm] = begin[arm] + share * (goal - begin)[arm]
            yield
        yield from self.wait(0.15)

    def stay(self) -> None:
        """Let the arm be where it is, whatever it has been on its way to."""
        arm = self.gripper.arm
        self.wanted[arm] = self._before[arm] = np.array(self.session.joints.position)[arm]

    def shift(self, by_m: Array) -> None:
        """Move the pads' middle by (3,) metres from where it is to be; stays where the arm cannot follow."""
        self.wanted = self.postures.shifted(self.wanted, by_m)

    def open(self, opening_m: float | None = None) -> Steps:
        """Open each pad to a distance from the middle; by default all the way that the guard lets it."""
        goal = self.gripper.most_open_m - END_M if opening_m is None else opening_m
        pads = self.gripper.joints
        while np.abs(goal - self.wanted[pads]).max() > 1e-6:
            self.move_pads(np.clip(goal - self.wanted[pads], -PAD_SPEED_M_S * LOOK_S, PAD_SPEED_M_S * LOOK_S))
            yield
        if opening_m is None:
            self._lost.forget()

    def move_pads(self, by_m: Array | float) -> None:
        """Move the pads by (2,) metres, outwards; pads whose cells are lost move no further inwards."""
        if self.lost.any():
            by_m = np.maximum(by_m, 0.0)
        robot, pads = self.session.robot, self.gripper.joints
        self.wanted[pads] = np.clip(self.wanted[pads] + by_m, robot.lower[pads], robot.upper[pads])


def _carrying(force_n: Array) -> int:
    return max(int((force_n > CARRIES_SHARE * force_n.sum()).sum()), 1)
