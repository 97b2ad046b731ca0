# SPDX-License-Identifier: Apache-2.0
"""Goals of behaviours: given, refused with a reason, and how far the robot is from them."""

from __future__ import annotations

from typing import Literal

import numpy as np
from numpy.typing import NDArray

from robotskin.control.goal_bounds import require_balance, require_reach
from robotskin.errors import InputError
from robotskin.model import RobotDynamics
from robotskin.session.reasons import missed_goal_told
from robotskin.session.skinned_robot import SkinnedRobot
from robotskin.tasks import CartesianTask, JointTask

Array = NDArray[np.float64]
GoalKind = Literal["", "joints", "hand"]

REACHED_RAD, REACHED_M = 0.02, 0.02
"""How far from its goal a robot that was touched on the way may end."""
STANDS = {"joints": 1e-4, "hand": 1e-5}
"""A reference that moves less than this, rad or m, between two looks has arrived."""


def goal_kind(session: SkinnedRobot) -> GoalKind:
    """What the behaviour takes for a goal: positions of joints, a place of the hand, or nothing."""
    tasks = session.controller.tasks.values()
    if any(isinstance(task, JointTask) for task in tasks):
        return "joints"
    return "hand" if any(isinstance(task, CartesianTask) for task in tasks) else ""


def hand_link(session: SkinnedRobot) -> str:
    """The link that Cartesian tasks move."""
    return str(session.gains.values["cartesian"]["link"])


def hand_pose(session: SkinnedRobot, dynamics: RobotDynamics | None = None) -> Array:
    """(4, 4) metres, base frame: the link of the robot's Cartesian tasks, as measured.

    The dynamics of the session's robot are used where they are given, which saves making them.
    """
    robot = session.robot.core
    dynamics = dynamics or RobotDynamics(robot)
    dynamics.update(np.array(session.joints.position), np.zeros(robot.joint_count))
    return dynamics.base_from_link(robot.link_index(hand_link(session)))


def set_goal(session: SkinnedRobot, goal: list[float]) -> Array:
    """Give the behaviour its goal: (n) rad for joints, or (3) metres by which the hand is to move, base axes.

    Returns the goal: (n) rad or m, or (3) metres where the hand is to be, base frame.

    Raises InputError if the behaviour follows neither, for another count, or for a goal out of limits, reach or
    balance.
    """
    kind = goal_kind(session)
    if kind == "hand" and len(goal) != 3:
        raise InputError(f"goal of {len(goal)} numbers: the hand moves by 3, x, y and z in metres")
    place = hand_pose(session)[:3, 3] + goal if kind == "hand" else np.array(goal, dtype=float)
    session.controller.set_reference(reference_of(session, place))
    return place


def reference_of(session: SkinnedRobot, goal: Array) -> Array:
    """What the tasks take for a goal of their kind: (n) rad or m of the joints, or (3) metres where the hand is to be.

    The hand keeps the direction that it has. Raises InputError as `set_goal` does.
    """
    robot, kind = session.robot, goal_kind(session)
    if not kind:
        name = session.controller.behaviour.name
        raise InputError(f"goal for {name}: it goes where it is pushed and takes none")
    if not np.isfinite(goal).all():
        raise InputError(f"goal {goal.tolist()}: must be finite numbers")
    if kind == "joints":
        if len(goal) != robot.joint_count:
            raise InputError(f"goal of {len(goal)} numbers: {robot.name} has {robot.joint_count} joints")
        for name, value, lower, upper in zip(robot.joint_names, goal, robot.lower, robot.upper, strict=True):
            if not lower <= value <= upper:
                raise InputError(f"goal of {name}: {value:g} is outside of its limits, {lower:g} to {upper:g}")
        require_balance(robot.core, goal)
        return goal
    require_reach(robot.core, hand_link(session), goal, np.array(session.joints.position))
    pose = hand_pose(session)
    pose[:3, 3] = goal
    return pose


class GoalWatch:
    """How far a session is from the goal that it was given last, and why, looked at a few times a second.

    Goals are (n) rad or m of the joints, or (3) m of the hand in the base frame.
    """

    def __init__(self, session: SkinnedRobot, goal: Array | None = None) -> None:
        self.session = session
        self.goal = goal
        self._behaviour = session.behaviour
        self._reference: Array | None = None
        self._dynamics = RobotDynamics(session.robot.core)

    def given(self, goal: Array) -> None:
        """A goal was given: (n) rad or m of the joints, or (3) m of the hand."""
        self.goal = np.array(goal, dtype=float)

    def look(self) -> tuple[GoalKind, Array | None, float, str]:
        """Kind, goal (n) or (3), how far it is still (rad or m), and why it is not reached; empty where it is."""
        session = self.session
        kind = goal_kind(session)
        if session.behaviour != self._behaviour:
            self._behaviour, self.goal, self._reference = session.behaviour, None, None
        reference = self._present_reference(kind)
        moving = (
            reference is not None
            and self._reference is not None
            and float(np.abs(reference - self._reference).max()) > STANDS.get(kind, 0.0)
        )
        self._reference = reference
        if not kind or self.goal is None or reference is None:
            return kind, reference, 0.0, ""
        if kind == "joints":
            left = float(np.abs(np.array(session.joints.position) - self.goal).max())
        else:
            left = float(np.linalg.norm(hand_pose(session, self._dynamics)[:3, 3] - self.goal))
        if left <= (REACHED_RAD if kind == "joints" else REACHED_M):
            return kind, self.goal, left, ""
        unit = "rad" if kind == "joints" else "m"
        told = missed_goal_told(session.robot, np.array(session.joints.position), left, unit, moving)
        return kind, self.goal, left, told

    def _present_reference(self, kind: GoalKind) -> Array | None:
        for task in self.session.controller.tasks.values():
            if kind == "joints" and isinstance(task, JointTask):
                return np.array(task.reference)
            if kind == "hand" and isinstance(task, CartesianTask):
                return np.array(task.reference)[:3, 3]
        return None
