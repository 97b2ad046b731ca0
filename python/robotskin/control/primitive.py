# SPDX-License-Identifier: Apache-2.0
"""The primitive generator: a goal selects behaviour, reference and, through the behaviour, tasks, fusion and gains."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field, replace

import numpy as np
from numpy.typing import ArrayLike, NDArray

from robotskin.control.behaviour import BEHAVIOURS, PRESS, Behaviour, behaviour
from robotskin.control.goal import CartesianGoal, ForceGoal, JointGoal, LimbGoal
from robotskin.errors import InputError


@dataclass(frozen=True)
class Primitive:
    """What the robot is to do: a behaviour, and by task the reference, where it has one.

    A reference is (n) rad, (4, 4) metres, or (3) newton.
    """

    behaviour: Behaviour
    references: Mapping[str, NDArray[np.float64]] = field(default_factory=dict)


def primitive(goal: LimbGoal) -> Primitive:
    """The primitive that reaches a goal. Raises InputError for a goal that is none, or of the wrong shape."""
    if isinstance(goal, JointGoal):
        chosen = behaviour("reach_joint_goal_compliant" if goal.gradually else "skin_compliance")
        return Primitive(chosen, {"spline_joint" if goal.gradually else "joint": joint_position(goal)})
    if isinstance(goal, CartesianGoal):
        name = "reach_cartesian_goal_compliant" if goal.gradually else "reach_cartesian_compliant"
        task = "spline_cartesian" if goal.gradually else "cartesian"
        return Primitive(_of_link(behaviour(name), task, goal.link), {task: pose(goal)})
    if isinstance(goal, ForceGoal) and goal.force_n is not None:
        return Primitive(_of_link(PRESS, "force", goal.link), {"force": force(goal)})
    if isinstance(goal, ForceGoal):
        return Primitive(behaviour("kinesthetic_cartesian" if goal.hand else "kinesthetic_joint"))
    raise InputError(
        f"{goal!r} is no goal: choose JointGoal, CartesianGoal, ForceGoal or LimbGoals; behaviours {list(BEHAVIOURS)}"
    )


def joint_position(goal: JointGoal) -> NDArray[np.float64]:
    """(n) rad. Raises InputError."""
    position = _numbers("joint goal", goal.position, "must be (n) finite radians")
    if position.ndim != 1:
        raise InputError(f"joint goal of shape {position.shape}: must be (n) finite radians")
    return position


def pose(goal: CartesianGoal) -> NDArray[np.float64]:
    """(4, 4) base_from_link. Raises InputError."""
    placement = _numbers("Cartesian goal", goal.base_from_link, "must be a finite (4, 4) placement")
    if placement.shape != (4, 4):
        raise InputError(f"Cartesian goal of shape {placement.shape}: must be a finite (4, 4) placement")
    return placement


def force(goal: ForceGoal) -> NDArray[np.float64]:
    """(3) newton of a goal that states some. Raises InputError."""
    newton = _numbers("force goal", goal.force_n, "must be (3) finite newton")
    if newton.shape != (3,) or goal.hand:
        raise InputError(f"force goal of shape {newton.shape}, hand={goal.hand}: must be (3) newton, or hand alone")
    return newton


def _of_link(chosen: Behaviour, task: str, link: str) -> Behaviour:
    """The behaviour, one of its tasks and all that touch moves for another link than the gain file's."""
    if not link:
        return chosen
    moved = [name for name in chosen.tasks if name in (task, "skin_cartesian")]
    return replace(chosen, parts={name: replace(chosen.part(name), link=link) for name in moved})


def _numbers(what: str, values: ArrayLike | None, must: str) -> NDArray[np.float64]:
    try:
        numbers = np.asarray(values, dtype=float)
    except (TypeError, ValueError):
        raise InputError(f"{what} {values!r}: {must}") from None
    if not np.isfinite(numbers).all():
        raise InputError(f"{what} {numbers.tolist()}: {must}")
    return numbers
