# SPDX-License-Identifier: Apache-2.0
"""The primitive generator: a goal selects behaviour, reference and, through the behaviour, tasks, fusion and gains."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray

from robotskin.control.behaviour import BEHAVIOURS, PRESS, Behaviour, behaviour
from robotskin.errors import InputError


@dataclass(frozen=True)
class JointGoal:
    """Bring the joints to `position` (n) rad; `gradually` along a spline, else at once."""

    position: ArrayLike
    gradually: bool = True


@dataclass(frozen=True)
class CartesianGoal:
    """Bring the hand to `base_from_link` (4, 4) metres; `gradually` along a spline, else at once."""

    base_from_link: ArrayLike
    gradually: bool = True


@dataclass(frozen=True)
class ForceGoal:
    """Press with `force_n` (3) newton along the axes of the base, as the skin on and beyond `link` measures it.

    Without a force: yield, let those who push lead the joints, or with `hand` the hand.
    """

    hand: bool = False
    force_n: ArrayLike | None = None
    link: str = ""
    """The link that presses; by default the one that Cartesian tasks move."""


Goal = JointGoal | CartesianGoal | ForceGoal


@dataclass(frozen=True)
class Primitive:
    """What the robot is to do: a behaviour, and its tasks' reference, if they have one.

    The reference is (n) rad, (4, 4) metres, or (3) newton with which `link` presses.
    """

    behaviour: Behaviour
    reference: NDArray[np.float64] | None = None
    link: str = ""


def primitive(goal: Goal) -> Primitive:
    """The primitive that reaches a goal. Raises InputError for a goal that is none, or of the wrong shape."""
    if isinstance(goal, JointGoal):
        position = _numbers("joint goal", goal.position, "must be (n) finite radians")
        if position.ndim != 1:
            raise InputError(f"joint goal of shape {position.shape}: must be (n) finite radians")
        return Primitive(behaviour("reach_joint_goal_compliant" if goal.gradually else "skin_compliance"), position)
    if isinstance(goal, CartesianGoal):
        pose = _numbers("Cartesian goal", goal.base_from_link, "must be a finite (4, 4) placement")
        if pose.shape != (4, 4):
            raise InputError(f"Cartesian goal of shape {pose.shape}: must be a finite (4, 4) placement")
        name = "reach_cartesian_goal_compliant" if goal.gradually else "reach_cartesian_compliant"
        return Primitive(behaviour(name), pose)
    if isinstance(goal, ForceGoal) and goal.force_n is not None:
        force = _numbers("force goal", goal.force_n, "must be (3) finite newton")
        if force.shape != (3,) or goal.hand:
            raise InputError(f"force goal of shape {force.shape}, hand={goal.hand}: must be (3) newton, or hand alone")
        return Primitive(PRESS, force, goal.link)
    if isinstance(goal, ForceGoal):
        return Primitive(behaviour("kinesthetic_cartesian" if goal.hand else "kinesthetic_joint"))
    raise InputError(
        f"{goal!r} is no goal: choose JointGoal, CartesianGoal or ForceGoal; behaviours {list(BEHAVIOURS)}"
    )


def _numbers(what: str, values: ArrayLike, must: str) -> NDArray[np.float64]:
    try:
        numbers = np.asarray(values, dtype=float)
    except (TypeError, ValueError):
        raise InputError(f"{what} {values!r}: {must}") from None
    if not np.isfinite(numbers).all():
        raise InputError(f"{what} {numbers.tolist()}: {must}")
    return numbers
