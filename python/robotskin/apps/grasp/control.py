# SPDX-License-Identifier: Apache-2.0
"""The hand's controller: looks at the skin at its own rate, goes through the states, and moves the references."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

import numpy as np
from numpy.typing import NDArray

from robotskin.apps.grasp.carriage import Carriage
from robotskin.apps.grasp.contacts import DEEPEST_M, Shape, find_contacts, plan_paths
from robotskin.apps.grasp.estimate import COVER_M, estimate_centre
from robotskin.apps.grasp.fingers import Hand
from robotskin.apps.grasp.shares import equilibrium_shares
from robotskin.apps.grasp.states import Seen, State, following
from robotskin.apps.grasp.tasks import use_grasp
from robotskin.session import PERIOD_S, Session

Array = NDArray[np.float64]
Method = Literal["reactive", "primitive"]

PERIODS = 4
"""Of the session, between two looks: a cell samples every 4 ms."""
LOOK_S = PERIODS * PERIOD_S
OPEN_M, SURVEY_M, NEAR_M = 0.030, 0.012, 0.004
SPEED_M_S, TOUCH_SPEED_M_S = 0.030, 0.003
PRIMITIVE_DEPTH_M = 0.012
"""How far inside of the believed surface the primitive grasp closes."""
GIVE_M_S_N = 0.006
"""How fast a finger moves for a newton that it lacks."""
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
        self.grip = grip or Grip()
        self.hand = Hand(session.robot, session.layout)
        self.contacts = find_contacts(self.hand, shape)
        self.centre = self.contacts.centre
        """(3,) metres, where the thing is believed to be, the carriage at 0."""
        self.paths = plan_paths(self.hand, shape, self.contacts)
        self.shares = self._shares()
        self.state = State.OPENING
        self.since_s = 0.0
        self.distance = np.full(4, OPEN_M)
        """(4,) metres along the paths, from the surface as it is believed; below 0 inside of it."""
        self.force = np.zeros(4)
        """(4,) newton that each finger's front feels."""
        self.near = np.full(4, np.inf)
        """(4,) metres from each pad, as its cell takes it."""
        self.strength = 1.0
        """By which slips have made the squeeze stronger."""
        self.carriage = Carriage()
        self._scale = _Scales()
        self._asked_to_release = False
        self._tick = 0
        self._earlier: list[Array] = []
        self._tare, self._tares = np.zeros(4), 0
        self._from: Array | None = None
        angles = np.array(session.joints.position)
        self._reference = angles
        self.task = use_grasp(session, self.hand)

    def release(self) -> None:
        """Let go of what is held."""
        self._asked_to_release = True

    def restart(self) -> None:
        """Open, and grasp again from the first belief."""
        self._asked_to_release = False
        self.state, self.since_s, self.strength = State.OPENING, 0.0, 1.0
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
        self.state = following(self.state, self._seen())
        self.since_s = 0.0 if self.state is not before else self.since_s + LOOK_S
        if self.state is not before:
            self._enter()
        self._act()
        self._send()

    # ---- What it sees ----

    def _look(self) -> None:
        cells = np.asarray(self.session.skin.normal_force).sum(axis=1)
        force = np.array([cells[front].sum() for front in self.hand.front])
        if self.state is State.OPENING:
            self._tare, self._tares = self._tare + force, self._tares + 1
            force = np.zeros(4)
        else:
            force = force - self._tare / max(self._tares, 1)
        if self.state is State.HOLD and self.method == "reactive" and self._slips(force):
            self.strength = min(SLIP_GAIN * self.strength, SLIP_MOST)
        self.force = force
        self.near = np.asarray(self.session.skin.distance, dtype=float)[self.hand.tip]

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
            reactive=self.method == "reactive",
            open=bool((self.distance >= OPEN_M - 1e-6).all()),
            surveyed=bool((off | touches).all()),
            near=bool((close | (self.force >= 0.6 * self.grip.touch_n)).all()),
            touching=bool(touches.all()),
            closed=bool((self.distance <= -PRIMITIVE_DEPTH_M + 1e-6).all())
            and self.since_s > 0.3 + (OPEN_M + PRIMITIVE_DEPTH_M) / SPEED_M_S,
            held=bool((self.force > HELD_N).sum() >= 2),
            asked_to_release=self._asked_to_release,
        )

    # ---- What it does ----

    def _enter(self) -> None:
        if self.state is State.MOVING:
            self._from = self._reference[self.hand.joints].copy()
            self.centre = self._estimate()
            self.paths = plan_paths(self.hand, self.shape, self.contacts, self.centre)
            self.shares = self._shares()
            self.distance = np.full(4, SURVEY_M + 0.002)
        if self.state in (State.APPROACH, State.CLOSING):
            self._from = None

    def _act(self) -> None:
        touch, state = self.grip.touch_n, self.state
        if state in (State.OPENING, State.RELEASE):
            self._move(np.full(4, SPEED_M_S))
        elif state is State.CLOSING:
            self.distance = np.maximum(self.distance - SPEED_M_S * LOOK_S, -PRIMITIVE_DEPTH_M)
        elif state in (State.SURVEY, State.APPROACH):
            seen = self.near
            if state is State.APPROACH:
                self._scale.learn(self.distance, self.near)
                seen = self._scale.true(self.near)
            error = np.minimum(seen, 0.06) - (SURVEY_M if state is State.SURVEY else NEAR_M)
            error = np.where(self.force < touch, error, -0.002)
            self._move(-np.clip(6 * error, -SPEED_M_S, SPEED_M_S))
        elif state is State.TOUCHING:
            far = np.clip(self._scale.true(self.near), 0, 0.02)
            speed = TOUCH_SPEED_M_S * np.clip(far / max(float(far.mean()), 1e-4), 0.5, 1.5)
            self._move(np.where(self.force < touch, -speed, 0.0))
        elif state is State.SQUEEZE:
            rise = min(1.0, self.since_s)
            wanted = touch + (self.grip.force_n * self.shares - touch) * rise
            self._move(-np.clip(GIVE_M_S_N * (wanted - self.force), -0.01, 0.01))
        elif state is State.HOLD and self.method == "reactive":
            wanted = self.strength * self.grip.force_n * self.shares
            lacks = float((wanted - self.force).sum() / self.shares.sum())
            self._move(np.full(4, -np.clip(GIVE_M_S_N * lacks, -0.005, 0.005)))

    def _move(self, speed: Array) -> None:
        self.distance = np.clip(self.distance + LOOK_S * speed, DEEPEST_M + 0.001, OPEN_M)

    def _send(self) -> None:
        angles = self.paths.at(self.distance)
        if self.state is State.MOVING and self._from is not None:
            share = min(1.0, self.since_s / 0.5)
            share = share * share * (3 - 2 * share)
            angles = (1 - share) * self._from + share * angles
        if self.state is State.OPENING:
            share = min(1.0, self.since_s / 0.4)
            angles = (1 - share) * self._reference[self.hand.joints] + share * angles
        position = self._reference.copy()
        position[self.hand.joints] = angles
        position[self.hand.lift], lift_velocity = self.carriage.step(LOOK_S)
        velocity = (position - self._reference) / LOOK_S
        velocity[self.hand.lift] = lift_velocity
        self._reference = position
        self.task.request_reference(position, velocity)

    def _estimate(self) -> Array:
        pads = self.hand.pads(np.array(self.session.joints.position)[self.hand.joints])
        found = estimate_centre(pads.place, pads.normal, self.near, self.shape, self.centre)
        shift = found - self.centre
        return np.asarray(self.centre + shift * min(1.0, FARTHEST_SHIFT_M / max(float(np.linalg.norm(shift)), 1e-9)))

    def _shares(self) -> Array:
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
