"""The primitive generator: a goal selects behaviour, reference and, through the behaviour, tasks, fusion and gains."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray

from robotskin.control.behaviour import BEHAVIOURS, Behaviour, behaviour
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
    """Yield: let whoever pushes lead the joints, or with `hand` the hand. The force that the robot opposes is none."""

    hand: bool = False


Goal = JointGoal | CartesianGoal | ForceGoal


@dataclass(frozen=True)
class Primitive:
    """What the robot is to do: a behaviour, and its tasks' reference, (n) rad or (4, 4) metres, if they have one."""

    behaviour: Behaviour
    reference: NDArray[np.float64] | None = None


def primitive(goal: Goal) -> Primitive:
    """The primitive that reaches a goal. Raises InputError for a goal that is none, or of the wrong shape."""
    if isinstance(goal, JointGoal):
        position = np.asarray(goal.position, dtype=float)
        if position.ndim != 1 or not np.isfinite(position).all():
            raise InputError(f"joint goal of shape {position.shape}: must be (n) finite radians")
        return Primitive(behaviour("reach_joint_goal_compliant" if goal.gradually else "skin_compliance"), position)
    if isinstance(goal, CartesianGoal):
        pose = np.asarray(goal.base_from_link, dtype=float)
        if pose.shape != (4, 4) or not np.isfinite(pose).all():
            raise InputError(f"Cartesian goal of shape {pose.shape}: must be a finite (4, 4) placement")
        name = "reach_cartesian_goal_compliant" if goal.gradually else "reach_cartesian_compliant"
        return Primitive(behaviour(name), pose)
    if isinstance(goal, ForceGoal):
        return Primitive(behaviour("kinesthetic_cartesian" if goal.hand else "kinesthetic_joint"))
    raise InputError(
        f"{goal!r} is no goal: choose JointGoal, CartesianGoal or ForceGoal; behaviours {list(BEHAVIOURS)}"
    )
