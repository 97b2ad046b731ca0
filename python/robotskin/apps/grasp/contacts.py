# SPDX-License-Identifier: Apache-2.0
"""Where four fingers touch a ball, a cylinder or the handles of a tool, and the paths on which they come."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from robotskin.apps.grasp.fingers import Hand
from robotskin.session import SessionError

Array = NDArray[np.float64]

FARTHEST_M, DEEPEST_M = 0.032, -0.030
"""Of the paths: the pad's distance from the surface, and how far inside of it the path goes on."""
_STEPS = 32
_ASIDE_M = 0.003
_FARTHEST_ASIDE_M = 0.008
_BESIDE_TRIES = 6
_UP = np.array([0.0, 0.0, 1.0])
_FROM_END_RAD = 0.08
"""Kept from the ends of joints, since what a finger holds bends it."""
_REST = np.array([[-0.3, 0.2, 1.5, 0.1], [0.0, 0.2, 1.5, 0.1], [0.3, 0.2, 1.5, 0.1], [1.33, 0.3, 0.3, 1.0]])
"""rad, what the fingers prefer."""


@dataclass(frozen=True)
class Shape:
    """What is to be grasped: a ball, an upright cylinder, or two upright handles, `flat` and on both sides of a gap.

    radius_m: from the middle to the surface; length_m: of a cylinder or of handles, 0 for a ball.
    """

    radius_m: float
    length_m: float = 0.0
    flat: bool = False

    @property
    def seen(self) -> Array:
        """(3,) the axes along which its surface is curved: 0 along the axis of a cylinder, and of what is flat."""
        if self.flat:
            return np.zeros(3)
        return np.array([1.0, 1.0, 0.0 if self.length_m else 1.0])

    @property
    def half_height_m(self) -> float:
        """From its middle down to where it stands."""
        return self.length_m / 2 if self.length_m else self.radius_m


@dataclass(frozen=True, eq=False)
class Contacts:
    """centre: (3,) metres, of the thing, in the hand's frame; outward: (4, 3) from there to each contact.

    height: (4,) metres of each contact above the centre, along the axis of a cylinder; facing: (4, 3) normals of the
    pads there; angles: (4, 4) rad.
    """

    centre: Array
    outward: Array
    height: Array
    facing: Array
    angles: Array


@dataclass(frozen=True, eq=False)
class Paths:
    """(S,) distances of a pad from the surface, rising, and (4, S, 4) rad of each finger there; error_m: the worst."""

    distance: Array
    angles: Array
    error_m: float

    def at(self, distance: Array) -> Array:
        """(4, 4) rad with each pad at its own distance of (4,) metres."""
        place = np.clip(
            (distance - self.distance[0]) / (self.distance[1] - self.distance[0]), 0, len(self.distance) - 1.001
        )
        low = place.astype(int)
        share = (place - low)[:, None]
        fingers = np.arange(4)
        return (1 - share) * self.angles[fingers, low] + share * self.angles[fingers, low + 1]


@dataclass(frozen=True, eq=False)
class _Grip:
    """See `Contacts`; outward need not have the length 1."""

    centre: Array
    outward: Array
    height: Array


_BALL = _Grip(
    np.array([0.099, -0.018, 0.0]),
    np.array([[-0.37, -0.73, 0.58], [-0.40, -0.91, 0.0], [-0.37, -0.73, -0.58], [0.30, 0.90, 0.20]]),
    np.zeros(4),
)
"""Index and ring finger reach around as far as their sideways joints let them: their pads lean by some 23 degrees."""
_CYLINDER = _Grip(
    np.array([0.081, -0.028, 0.006]),
    np.array([[-0.42, -0.91, 0.0], [-0.36, -0.93, 0.0], [-0.42, -0.91, 0.0], [0.30, 0.95, 0.0]]),
    np.array([0.045, 0.0, -0.045, 0.012]),
)
_CLOSING = np.array([np.sin(np.deg2rad(20)), np.cos(np.deg2rad(20)), 0.0])
"""From the fingers' handle to the thumb's: pads lie on both within 10 degrees."""
_HANDLES = _Grip(
    np.array([0.075, -0.030, 0.006]),
    np.array([-_CLOSING, -_CLOSING, -_CLOSING, _CLOSING]),
    np.array([0.045, 0.0, -0.045, 0.025]),
)


def find_contacts(hand: Hand, shape: Shape) -> Contacts:
    """Where the pads touch a thing of this shape, and the joints that bring them there.

    Raises SessionError for a shape that the fingers cannot reach around.
    """
    grip = _HANDLES if shape.flat else _CYLINDER if shape.length_m else _BALL
    outward = grip.outward / np.linalg.norm(grip.outward, axis=1)[:, None]
    place = grip.centre + outward * shape.radius_m + np.outer(grip.height, [0.0, 0.0, 1.0])
    angles, error = _REST, np.ones(4)
    for _ in range(4):
        angles, error = _reached(hand, angles, place, -outward)
    if error.max() > _ASIDE_M or np.abs(grip.height).max() > shape.half_height_m:
        raise SessionError(
            f"grasp of a thing of {1e3 * shape.radius_m:g} mm radius and {2e3 * shape.half_height_m:g} mm height: the "
            "fingers do not reach its surface; tried are balls of 28 to 38 mm and cylinders of 23 to 33 mm, 110 mm high"
        )
    return Contacts(grip.centre, outward, grip.height, hand.pads(angles).normal, angles)


def moved_contacts(hand: Hand, shape: Shape, contacts: Contacts, centre: Array) -> Contacts:
    """The contacts on a thing at another (3,) `centre`. A finger that cannot get to its own touches beside it."""
    outward, height, angles = contacts.outward.copy(), contacts.height.copy(), contacts.angles
    facing = contacts.facing.copy()
    for _ in range(_BESIDE_TRIES):
        place = centre + outward * shape.radius_m + np.outer(height, _UP)
        angles, error = _reached(hand, angles, place, facing)
        away = error > _ASIDE_M / 2
        if not away.any():
            break
        found = hand.pads(angles).place - centre
        height = np.where(away & (shape.length_m > 0), found @ _UP, height)
        level = found * shape.seen
        turned = level / np.linalg.norm(level, axis=1)[:, None]
        outward = np.where(away[:, None], turned, outward)
        facing = np.where(away[:, None], -outward, facing)
    facing = np.where((facing == contacts.facing).all(axis=1)[:, None], facing, hand.pads(angles).normal)
    return Contacts(centre, outward, height, facing, angles)


def plan_paths(hand: Hand, shape: Shape, contacts: Contacts, centre: Array | None = None) -> Paths:
    """Joint paths along which each pad comes straight to its contact, facing it, for a thing at another `centre`."""
    middle = contacts.centre if centre is None else centre
    distances = np.linspace(DEEPEST_M, FARTHEST_M, _STEPS)
    table = np.zeros((4, _STEPS, 4))
    worst = 0.0
    begin = int(np.argmin(np.abs(distances)))
    for order in (range(begin, _STEPS), range(begin - 1, -1, -1)):
        angles = contacts.angles if order.step > 0 else table[:, begin]
        for index in order:
            place = middle + contacts.outward * (shape.radius_m + distances[index])
            place = place + np.outer(contacts.height, _UP)
            found, error = _reached(hand, angles, place, contacts.facing)
            # Where a finger cannot get, its path ends.
            angles = np.where((error < _FARTHEST_ASIDE_M)[:, None], found, angles)
            table[:, index] = angles
            if -0.006 <= distances[index] <= 0.02:
                worst = max(worst, float(error.max()))
    return Paths(distances, table, worst)


def _reached(hand: Hand, angles: Array, place: Array, normal: Array) -> tuple[Array, Array]:
    """(4, 4) rad that bring the pads to (4, 3) places, facing along (4, 3) normals as well as four joints can.

    And (4,) metres that each pad then is away from its place.
    """
    lower, upper = hand.lower + _FROM_END_RAD, hand.upper - _FROM_END_RAD
    for _ in range(15):
        pads = hand.pads(angles)
        error = np.concatenate(
            [100 * (place - pads.place), 0.5 * (normal - pads.normal), 0.02 * (_REST - angles)], axis=1
        )
        rows = np.concatenate([100 * pads.moves, 0.5 * pads.turns, np.tile(0.02 * np.eye(4), (4, 1, 1))], axis=1)
        free = np.ones((4, 4), dtype=bool)
        for _ in range(3):  # a joint at an end takes no part in a step that leads beyond it
            used = rows * free[:, None, :]
            square = np.einsum("fij,fik->fjk", used, used) + 1e-9 * np.eye(4)
            step = np.linalg.solve(square, np.einsum("fij,fi->fj", used, error)[..., None])[..., 0]
            blocked = free & (((angles <= lower) & (step < 0)) | ((angles >= upper) & (step > 0)))
            if not blocked.any():
                break
            free &= ~blocked
        step = np.where(free, step, 0.0)
        angles = np.clip(angles + np.clip(step, -0.3, 0.3), lower, upper)
        if np.abs(step).max() < 1e-4:
            break
    return angles, np.linalg.norm(hand.pads(angles).place - place, axis=1)
