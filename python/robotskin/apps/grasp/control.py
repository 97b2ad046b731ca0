# SPDX-License-Identifier: Apache-2.0
"""The hand's controller: looks at the skin at its own rate, goes through the states, and moves the references."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

import numpy as np
from numpy.typing import NDArray

from robotskin.apps.grasp.carriage import Carriage
from robotskin.apps.grasp.contacts import DEEPEST_M, Shape, find_contacts, moved_contacts, plan_paths
from robotskin.apps.grasp.estimate import COVER_M, estimate_centre
from robotskin.apps.grasp.fingers import Hand, Pads
from robotskin.apps.grasp.give_way import GiveWay
from robotskin.apps.grasp.levers import MOST_N, Levers
from robotskin.apps.grasp.scene import HINGE_M
from robotskin.apps.grasp.shares import equilibrium_shares
from robotskin.apps.grasp.states import Seen, State, following
from robotskin.apps.grasp.tasks import grasp_gains, use_grasp
from robotskin.session import PERIOD_S, LostCells, Session
from robotskin.world.scene import SKIN_STIFFNESS_N_PER_M

Array = NDArray[np.float64]
Method = Literal["reactive", "primitive", "equal"]
"""equal: as reactive, and each finger presses alike; of what has handles alone."""

PERIODS = 4
"""Of the session, between two looks: a cell samples every 4 ms."""
LOOK_S = PERIODS * PERIOD_S
OPEN_M, SURVEY_M, NEAR_M = 0.030, 0.012, 0.004
SPEED_M_S, TOUCH_SPEED_M_S = 0.030, 0.003
SURVEY_PER_S, SURVEY_M_S = 4.0, 0.020
APPROACH_PER_S, APPROACH_M_S = 2.5, 0.012
"""How fast a missing distance goes, and the most. A leaning pad meets a ball with its edge before its middle says so.
Behind it is the rotors' inertia, some 1.5 kg: at 5 mm/s that is half a newton."""
PRIMITIVE_DEPTH_M = 0.012
"""How far inside of the believed surface the primitive grasp closes."""
DRAW_BACK_M_S = 0.012
"""Of a finger that feels something too early."""
GIVE_M_S_N = 0.006
"""How fast a finger moves for a newton that it lacks."""
PRESS_PER_S, FOLLOW_PER_S = 4.0, 20.0
"""How fast a lack of force is made up for, and how fast a finger's path follows its pad."""
SLIP_GAIN, SLIP_MOST = 1.2, 2.0
SLIP_SHARE, SLIP_LEAST_N, SLIP_LOOKS = 0.7, 0.5, 5
"""A slip: of half a newton or more less than this share is left after so many looks."""
HELD_N = 0.1
FARTHEST_SHIFT_M = 0.02


@dataclass(frozen=True)
class Grip:
    """force_n: of a finger with a share of 1; touch_n: at which a finger counts as touching."""

    force_n: float = 1.5
    touch_n: float = 0.10


class GraspControl:
    """Grasps with the hand of a session that has booted; call `step` after each of its steps."""

    def __init__(self, session: Session, shape: Shape, method: Method = "reactive", grip: Grip | None = None) -> None:
        self.session, self.shape, self.method = session, shape, method
        # With handles a share is a newton.
        self.grip = grip or (Grip(force_n=1.0) if shape.flat else Grip())
        self.hand = Hand(session.robot, session.layout)
        self._believed = find_contacts(self.hand, shape)
        self.contacts = self._believed
        self.centre = self.contacts.centre
        """(3,) metres, where the thing is believed to be, in the hand's frame."""
        self.paths = plan_paths(self.hand, shape, self.contacts)
        self.levers: Levers | None = None
        """Of what has handles."""
        self.shares = self._shares()
        self.state, self.because = State.BRINGING, ""
        self.since_s = 0.0
        self.lost: NDArray[np.bool_] = np.zeros(4, dtype=bool)
        """(4,) fingers whose pad's cell is lost, or a cell of whose front is lost that felt something."""
        self._lost = LostCells(len(session.layout))
        self._cells = np.zeros(len(session.layout))
        self.distance = np.full(4, OPEN_M)
        """(4,) metres along the paths, from the surface as it is believed; below 0 inside of it."""
        self.force = np.zeros(4)
        """(4,) newton that each finger's front feels."""
        self.give_way = self._new_give_way()
        self.near = np.full(4, np.inf)
        """(4,) metres from each pad, as its cell takes it."""
        self.press = np.zeros(4)
        """(4,) newton with which the fingers press beside their springs."""
        self.strength = 1.0
        """By which slips have made the squeeze stronger."""
        self.carriage = Carriage()
        self._scale = _Scales()
        self._front = np.zeros((4, len(session.layout)))
        for finger, cells in enumerate(self.hand.front):
            self._front[finger, cells] = 1.0
        self._asked_to_release = False
        self._tick = 0
        self._earlier: list[Array] = []
        self._tare, self._tares = np.zeros(4), 0
        self._from: Array | None = None
        angles = np.array(session.joints.position)
        self._reference = angles
        self._stiffness = np.array(grasp_gains(self.hand, session.robot.joint_count).stiffness)[self.hand.joints]
        self.task, self.carrier = use_grasp(session, self.hand)

    def release(self) -> None:
        """Let go of what is held."""
        self._asked_to_release = True

    def restart(self) -> None:
        """Open, and grasp again from the first belief."""
        self._asked_to_release = False
        self._lost.forget()
        self.state, self.since_s, self.strength, self.because = State.BRINGING, 0.0, 1.0, ""
        self.press = np.zeros(4)
        self.contacts = self._believed
        self.give_way = self._new_give_way()
        self.centre = self.contacts.centre
        self.paths = plan_paths(self.hand, self.shape, self.contacts)
        self.shares = self._shares()
        self.distance = np.full(4, OPEN_M)
        self._scale = _Scales()
        self._tare, self._tares = np.zeros(4), 0

    def step(self) -> None:
        """One period of the session."""
        self._tick += 1
        if self._tick % PERIODS:
            return
        self._look()
        before = self.state
        self.state, because = following(before, self._seen())
        self.since_s = 0.0 if self.state is not before else self.since_s + LOOK_S
        if self.state is not before:
            self.because = because
            self._enter()
        self._act()
        self._send()

    # ---- What it sees ----

    def _look(self) -> None:
        self._cells = cells = self.session.cell_forces_n()
        self._lost.look(~self.session.fresh, cells > HELD_N)
        self.lost = self._lost.lost[self.hand.tip] | [self._lost.among(front) for front in self.hand.front]
        force = self._front @ cells
        if self.state is State.OPENING:
            self._tare, self._tares = self._tare + force, self._tares + 1
            force = np.zeros(4)
        else:
            force = force - self._tare / max(self._tares, 1)
        if self.lost.any():  # what they feel less is no slip
            self._earlier.clear()
        elif self.state is State.HOLD and self.method != "primitive" and self._slips(force):
            self.strength = min(SLIP_GAIN * self.strength, SLIP_MOST)
        self.force = force
        self.near = self.session.cell_distances_m()[self.hand.tip]

    def _slips(self, force: Array) -> bool:
        """Whether a finger has lost a third of its force within 20 ms: what it held has slid under it."""
        self._earlier.append(force)
        if len(self._earlier) <= SLIP_LOOKS:
            return False
        before = self._earlier.pop(0)
        slid = bool(((before > SLIP_LEAST_N) & (force < SLIP_SHARE * before)).any())
        if slid:
            self._earlier.clear()
        return slid

    def _seen(self) -> Seen:
        touches = self.force >= self.grip.touch_n
        off = np.abs(self.near - SURVEY_M) < 0.003
        close = np.abs(self._scale.true(self.near) - NEAR_M) < 0.0015
        return Seen(
            since_s=self.since_s,
            reactive=self.method != "primitive",
            brought=self.carrier.brought,
            open=bool((self.distance >= OPEN_M - 1e-6).all()),
            surveyed=bool((off | touches).all()),
            near=bool((close | (self.force >= 0.6 * self.grip.touch_n)).all()),
            touching=bool(touches.all()),
            closed=bool((self.distance <= -PRIMITIVE_DEPTH_M + 1e-6).all())
            and self.since_s > 0.3 + (OPEN_M + PRIMITIVE_DEPTH_M) / SPEED_M_S,
            risen=self.levers is None or self._reached_forces(),
            held=bool((self.force > HELD_N).sum() >= 2),
            asked_to_release=self._asked_to_release,
            lost=bool(self.lost.any()),
        )

    # ---- What it does ----

    def _enter(self) -> None:
        if self.state is State.MOVING:
            self._from = self._reference[self.hand.joints].copy()
            if self.shape.flat:  # each finger finds its handle by itself
                return
            self.centre = self._estimate()
            self.contacts = moved_contacts(self.hand, self.shape, self._believed, self.centre)
            self.paths = plan_paths(self.hand, self.shape, self.contacts)
            self.shares = self._shares()
            self.distance = np.full(4, SURVEY_M + 0.002)
        if self.state is State.SQUEEZE and self.levers is not None:
            self.levers.begin(self._closed(self._pressed()))
        if self.state in (State.APPROACH, State.CLOSING):
            self._from = None

    def _act(self) -> None:
        touch, state = self.grip.touch_n, self.state
        if state in (State.BRINGING, State.OPENING, State.RELEASE):
            self.press = np.zeros(4)
            self._move(np.full(4, SPEED_M_S))
        elif state is State.CLOSING:
            self.distance = np.maximum(self.distance - SPEED_M_S * LOOK_S, -PRIMITIVE_DEPTH_M)
        elif state in (State.SURVEY, State.APPROACH):
            seen = self.near
            if state is State.APPROACH:
                self._scale.learn(self.distance, self.near)
                seen = self._scale.true(self.near)
            wanted, rate, most = SURVEY_M, SURVEY_PER_S, SURVEY_M_S
            if state is State.APPROACH:
                wanted, rate, most = NEAR_M, APPROACH_PER_S, APPROACH_M_S
            speed = np.clip(rate * (np.minimum(seen, 0.06) - wanted), -most, most)
            self._move(-np.where(self.force < touch, speed, -DRAW_BACK_M_S))
        elif state is State.TOUCHING:
            far = np.clip(self._scale.true(self.near), 0, 0.02)
            speed = TOUCH_SPEED_M_S * np.clip(far / max(float(far.mean()), 1e-4), 0.5, 1.5)
            self._move(np.where(self.force < touch, -speed, 0.0))
        elif state is State.SQUEEZE:
            self._squeeze()
        elif state is State.HOLD and self.method != "primitive":
            self._hold()

    def _squeeze(self) -> None:
        """Each finger's force rises to its share."""
        touch = self.grip.touch_n
        if self.levers is not None:
            pressed = self._pressed()
            height = pressed[:, 2] - self.centre[2]
            if (self.force[:3] > 0.5 * touch).all():
                self.levers.feel(height[:3], self._closed(pressed))
            self.shares = self.levers.forces(height)
        rise = min(1.0, self.since_s)
        lacks = touch + (self.grip.force_n * self.shares - touch) * rise - self.force
        if self.levers is None:
            self._move(-np.clip(GIVE_M_S_N * lacks, -0.01, 0.01))
        else:
            self._press(lacks)

    def _hold(self) -> None:
        """The fingers close or open together; where a person pushes a finger from outside, all go along."""
        if self.give_way.step(np.array(self.session.joints.position), self._cells, LOOK_S):
            return
        if self.lost.any():  # no finger presses harder for want of what another felt
            return
        wanted = self.strength * self.grip.force_n * self.shares
        lacks = float((wanted - self.force).sum() / self.shares.sum())
        if self.levers is None:
            self._move(np.full(4, -np.clip(GIVE_M_S_N * lacks, -0.005, 0.005)))
        else:
            self.press = self.press + LOOK_S * PRESS_PER_S * np.clip(lacks, -0.2, 0.2) * self.shares

    def _pads(self) -> Pads:
        return self.hand.pads(np.array(self.session.joints.position)[self.hand.joints])

    def _move(self, speed: Array) -> None:
        self.distance = np.clip(self.distance + LOOK_S * speed, DEEPEST_M + 0.001, OPEN_M)

    def _press(self, lacks: Array) -> None:
        """Forces straight along the paths: a finger whose path ends where its pad is presses in no other direction."""
        self.press = np.clip(self.press + LOOK_S * PRESS_PER_S * lacks, 0.0, MOST_N)
        self._move(np.clip(FOLLOW_PER_S * (self._away() - self.distance), -0.05, 0.05))

    def _away(self) -> Array:
        """(4,) metres of the pads from the surface along their paths, as it is believed."""
        pads = self._pads()
        return np.asarray(((pads.place - self.centre) * self.contacts.outward).sum(axis=1) - self.shape.radius_m)

    def _send(self) -> None:
        angles = self.give_way.shifted(self.paths.at(self.distance))
        if self.press.any():
            torque = np.einsum("fij,fi->fj", self.hand.pads(angles).moves, -self.contacts.outward)
            angles = angles + torque * self.press[:, None] / self._stiffness
        if self.state is State.HOLD:
            measured = np.array(self.session.joints.position)[self.hand.joints]
            angles = self.give_way.kept_from_ends(angles, measured)
        angles = np.clip(angles, self.hand.lower, self.hand.upper)
        if self.state is State.MOVING and self._from is not None:
            share = min(1.0, self.since_s / 0.5)
            share = share * share * (3 - 2 * share)
            angles = (1 - share) * self._from + share * angles
        if self.state in (State.BRINGING, State.OPENING):
            share = min(1.0, self.since_s / 0.4)
            angles = (1 - share) * self._reference[self.hand.joints] + share * angles
        position = self._reference.copy()
        position[self.hand.joints] = angles
        carried, carried_velocity = self.carrier.step(*self.carriage.step(LOOK_S), LOOK_S)
        position[self.hand.carrier] = carried
        velocity = (position - self._reference) / LOOK_S
        velocity[self.hand.carrier] = carried_velocity
        self._reference = position
        self.task.request_reference(position, velocity)

    def _estimate(self) -> Array:
        pads = self._pads()
        found = estimate_centre(pads.place, pads.normal, self.near, self.shape, self.centre)
        shift = found - self.centre
        return np.asarray(self.centre + shift * min(1.0, FARTHEST_SHIFT_M / max(float(np.linalg.norm(shift)), 1e-9)))

    def _pressed(self) -> Array:
        """(4, 3) metres where the pads are pressed, in the hand's frame."""
        pads = self._pads()
        return pads.touched(self.session.cell_readings_n()[self.hand.tip])

    def _closed(self, pressed: Array) -> Array:
        """(3,) metres of the fingers' handle along the way in which it closes: the skin is pressed in on it."""
        return np.asarray(pressed[:3] @ self.contacts.outward[3] - self.force[:3] / SKIN_STIFFNESS_N_PER_M)

    def _new_give_way(self) -> GiveWay:
        """Handles are upright."""
        across = np.cross(self.contacts.outward[3], [0.0, 0.0, 1.0])
        return GiveWay(self.hand, across=across / np.linalg.norm(across) if self.shape.flat else None)

    def _reached_forces(self) -> bool:
        wanted = self.grip.force_n * self.shares
        return bool((np.abs(self.force - wanted) < np.maximum(0.1 * wanted, 0.15)).all())

    def _shares(self) -> Array:
        if self.shape.flat:
            self.levers = Levers(HINGE_M, self.shape.radius_m, even=self.method == "equal")
            return self.levers.forces(self.contacts.height)
        # A flat pad presses along its own normal, where the surface is parallel to it.
        inward = self.contacts.facing
        place = self.centre - self.shape.radius_m * inward * self.shape.seen
        return equilibrium_shares(self.centre, place + np.outer(self.contacts.height, [0.0, 0.0, 1.0]), inward)


class _Scales:
    """How far apparent distances are off, learnt from a finger's own motion: apparent over true steps, a slope each."""

    def __init__(self) -> None:
        self._moved: list[list[tuple[float, float]]] = [[], [], [], []]
        self.slope = np.ones(4)

    def learn(self, distance: Array, apparent: Array) -> None:
        """(4,) metres along the paths, and what the cells take for the distance."""
        for finger, known in enumerate(self._moved):
            if apparent[finger] > 0.03 or (known and abs(known[-1][0] - distance[finger]) < 2e-4):
                continue
            known.append((float(distance[finger]), float(apparent[finger])))
            if len(known) >= 8:
                latest = np.array(known[-60:])
                slope = float(np.polyfit(latest[:, 0], latest[:, 1], 1)[0])
                self.slope[finger] = np.clip((slope * len(latest) + 20.0) / (len(latest) + 20.0), 0.75, 1.35)

    def true(self, apparent: Array) -> Array:
        """(4,) metres."""
        return np.asarray(np.maximum((COVER_M + np.minimum(apparent, 1.0)) / self.slope - COVER_M, 0.0))
