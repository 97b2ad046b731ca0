# SPDX-License-Identifier: Apache-2.0
"""Motor babbling, part 3: the whole programme of an exploration, from which nothing is left to chance.

In: a free space and a start posture. Out: the way through few telling postures, and the swings of every joint in some
of them. Nothing here moves a robot; `robotskin.configuring.exploration` does.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from robotskin.robots.free_space import FreeSpace
from robotskin.selfconfig.babbling.joint_sine import JointSine, MotionLimits, plan_joint_sine
from robotskin.selfconfig.babbling.postures import BabblingError, PosturePlan, choose_postures

Array = NDArray[np.float64]

BASE_ROOM = 0.1
"""rad or m that a joint without limits, such as a wheel, may move away from where it stands."""


@dataclass(frozen=True, eq=False)
class BabblingPlan:
    """The postures to rest in and the way through them, and the swings to make in each.

    swings: (K) for each posture, those that start and end there; most postures have none.
    blocked: joints that can swing in none of the postures, with the reason.
    """

    postures: PosturePlan
    swings: tuple[tuple[JointSine, ...], ...]
    blocked: dict[str, str]


def plan_babbling(
    space: FreeSpace,
    start: Array,
    random: np.random.Generator,
    *,
    links: Sequence[str] | None = None,
    joints: Sequence[int] | None = None,
    postures: int = 8,
    swing_postures: int = 3,
    limits: MotionLimits = MotionLimits(),  # noqa: B008 - frozen
    frequency_hz: float = 1.0,
    cycles: int = 3,
    candidates: int = 200,
) -> BabblingPlan:
    """Plan an exploration.

    Args:
        space: where the robot may move.
        start: (n) where it stands.
        random: draws candidates.
        links: that may carry skin; by default all that have a surface and move.
        joints: to swing; by default all.
        postures: to rest in.
        swing_postures: in how many of them every joint swings; a joint whose axis is vertical in one of them tells
            nothing about gravity there, and a cell near its axis little.
        limits: of swings.
        frequency_hz: of swings; cycles: in each.
        cycles: see frequency_hz.
        candidates: random postures to choose from.

    Raises:
        BabblingError: the start is not free, or too few postures are.
    """
    robot = space.robot
    narrowed = _with_narrow_wheels(space, start)
    if links is None:
        carried = robot.core.link_joints
        links = [name for name in robot.links_with("collision") if carried[robot.link_index(name)] >= 0]
    rests = choose_postures(narrowed, links, start, random, postures, candidates)
    chosen = _different(rests.postures, swing_postures)
    swings: list[tuple[JointSine, ...]] = [()] * len(rests.postures)
    why: dict[int, str] = {}
    free: set[int] = set()
    for number in chosen:
        found = []
        for joint in range(robot.joint_count) if joints is None else joints:
            try:
                found.append(plan_joint_sine(narrowed, joint, rests.postures[number], limits, frequency_hz, cycles))
                free.add(joint)
            except BabblingError as error:
                why.setdefault(joint, str(error))
        swings[number] = tuple(found)
    blocked = {robot.joint_names[joint]: reason for joint, reason in why.items() if joint not in free}
    return BabblingPlan(rests, tuple(swings), blocked)


def _with_narrow_wheels(space: FreeSpace, start: Array) -> FreeSpace:
    """The same space, where joints without limits stay close to where they stand: gravity tells nothing of them."""
    endless = (space.robot.upper - space.robot.lower > 4 * np.pi + 1) | ~np.isfinite(space.robot.upper)
    space.lower = np.where(endless, start - BASE_ROOM, space.lower)
    space.upper = np.where(endless, start + BASE_ROOM, space.upper)
    return space


def _different(postures: Array, count: int) -> list[int]:
    """Numbers of `count` postures that are far from each other, the first among them."""
    chosen = [0]
    while len(chosen) < min(count, len(postures)):
        apart = np.abs(postures[:, None] - postures[chosen][None]).sum(axis=2).min(axis=1)
        chosen.append(int(np.argmax(apart)))
    return sorted(chosen)
