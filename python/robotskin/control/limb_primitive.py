# SPDX-License-Identifier: Apache-2.0
"""The primitive of several limbs at once: a task for each limb's goal, and the skin beside them (figure 10a)."""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from robotskin.control.behaviour import PRESS, Behaviour, Part
from robotskin.control.goal import CartesianGoal, ForceGoal, JointGoal, LimbGoal, LimbGoals
from robotskin.control.primitive import Primitive, force, joint_position, pose, primitive
from robotskin.errors import InputError, UnknownNameError
from robotskin.model import BASE, RobotModel
from robotskin.robots.limbs import limbs_of
from robotskin.tasks import FEEDFORWARD, Fusion, Limb

LIMB_GOALS = "limb_goals"
"""The name of their behaviour."""
HELD = "skin_compliance"
"""Whose gains limbs without a goal take."""


def limb_primitive(goals: LimbGoals, robot: RobotModel, link: str) -> Primitive:
    """The tasks of all limbs beside each other, above a posture of what they leave free [Cheng19 eq. 19, 20].

    Args:
        goals: of limbs.
        robot: n joints, whose limbs they are.
        link: which Cartesian tasks of the whole robot move; a limb that has it is moved by it, too.

    Raises:
        UnknownNameError: no such limb. InputError: no goal at all, or one that its limb cannot have.
    """
    limbs = {limb.name: limb for limb in limbs_of(robot)}
    if not goals.goals:
        raise InputError(f"no limb has a goal: limbs of {robot.name} are {', '.join(limbs)}")
    made = _Made(robot)
    for name, goal in goals.goals.items():
        if name not in limbs:
            raise UnknownNameError(f"limb of {robot.name}", name, limbs)
        made.add(limbs[name], goal, link)
    return made.primitive()


@dataclass
class _Made:
    """What the goals so far ask for."""

    robot: RobotModel
    tasks: dict[str, int] = field(default_factory=dict)
    parts: dict[str, Part] = field(default_factory=dict)
    references: dict[str, NDArray[np.float64]] = field(default_factory=dict)
    left_free: list[str] = field(default_factory=list)
    """Joints of limbs whose links have goals: what these leave free holds its posture."""
    named: set[str] = field(default_factory=set)
    """Joints of all limbs that have goals; the others hold their posture."""
    gains: dict[str, str] = field(default_factory=dict)
    """By joint, whose gains the reaction of its cells takes; the others' take those of what is held."""
    silent: set[str] = field(default_factory=set)
    """Joints whose cells feel what is meant: they do not give way to it."""

    def add(self, limb: Limb, goal: LimbGoal, link: str) -> None:
        """One limb's tasks."""
        alone = primitive(goal)  # refuses what is no goal
        if isinstance(goal, JointGoal):
            self._task(limb, "spline_joint" if goal.gradually else "joint", alone, self._position(limb, goal))
        elif isinstance(goal, CartesianGoal):
            moved = self._moved(limb, goal.link, link)
            self._task(limb, "spline_cartesian" if goal.gradually else "cartesian", alone, pose(goal), moved)
            self.left_free += limb.joints
        elif goal.force_n is not None:
            moved = self._moved(limb, goal.link, link)
            self._task(limb, "force", alone, force(goal), moved)
            self.left_free += limb.joints
            self.silent.update(self._carried_by(moved))
        elif goal.hand:
            self._task(limb, "skin_cartesian", alone, None, self._moved(limb, goal.link, link))
            self.silent.update(limb.joints)
        self.named.update(limb.joints)
        if not (isinstance(goal, ForceGoal) and goal.force_n is not None):
            self.gains |= dict.fromkeys(limb.joints, alone.behaviour.name)

    def primitive(self) -> Primitive:
        """Of all of them."""
        names = list(self.robot.joint_names)
        rest = [joint for joint in names if joint not in self.named]
        feeling: dict[str, list[str]] = {}
        for joint in names:
            if joint not in self.silent:
                feeling.setdefault(self.gains.get(joint, HELD), []).append(joint)
        if list(map(len, feeling.values())) == [len(names)]:
            self.tasks["skin"], self.parts["skin"] = 0, Part(next(iter(feeling)))
        else:
            for gains, joints in feeling.items():
                self.tasks[f"skin@{gains}"], self.parts[f"skin@{gains}"] = 0, Part(gains, tuple(joints))
        for task, level, joints in (("joint@rest", 0, rest), ("posture", 1, self.left_free)):
            if joints:
                self.tasks[task], self.parts[task] = level, Part(HELD, tuple(joints))
        told = ", ".join(
            f"{task} by {part.link or '+'.join(part.joints) or 'all'}" for task, part in self.parts.items()
        )
        tasks = {**self.tasks, "gravity": FEEDFORWARD}
        meaning = f"does for each limb what is asked of it: {told}"
        chosen = Behaviour(LIMB_GOALS, tasks, Fusion.null_space, meaning, gains=HELD, parts=self.parts)
        return Primitive(chosen, self.references)

    def _task(
        self, limb: Limb, kind: str, alone: Primitive, reference: NDArray[np.float64] | None, link: str = ""
    ) -> None:
        name = f"{kind}@{limb.name}"
        gains = PRESS.gains if kind == "force" else alone.behaviour.name
        self.tasks[name], self.parts[name] = 0, Part(gains, tuple(limb.joints), link)
        if reference is not None:
            self.references[name] = reference

    def _position(self, limb: Limb, goal: JointGoal) -> NDArray[np.float64]:
        """(n) of all joints; a task without gains for the others leaves them where they are."""
        asked = joint_position(goal)
        if len(asked) != len(limb.joints):
            raise InputError(
                f"joint goal of limb {limb.name} has {len(asked)} values, its joints are {', '.join(limb.joints)}"
            )
        position = np.clip(np.zeros(self.robot.joint_count), self.robot.lower, self.robot.upper)
        position[[list(self.robot.joint_names).index(joint) for joint in limb.joints]] = asked
        return position

    def _moved(self, limb: Limb, asked: str, usual: str) -> str:
        """The link that is asked for, the gain file's if the limb has it, or that of the limb's last joint."""
        robot = self.robot
        if asked:
            if self._joint_of(asked) not in limb.joints:
                choices = [link for link in robot.link_names if self._joint_of(link) in limb.joints]
                raise UnknownNameError(f"link of limb {limb.name}", asked, choices)
            return asked
        if self._joint_of(usual) in limb.joints:
            return usual
        return next(link for link in robot.link_names if self._joint_of(link) == limb.joints[-1])

    def _joint_of(self, link: str) -> str:
        joint = self.robot.link_joints[self.robot.link_index(link)]
        return "" if joint == BASE else self.robot.joint_names[joint]

    def _carried_by(self, link: str) -> list[str]:
        """The link's joint and those beyond it."""
        robot, carried = self.robot, {self._joint_of(link)}
        for joint, parent in zip(robot.joint_names, robot.joint_parents, strict=True):  # parents come first
            if parent != BASE and robot.joint_names[parent] in carried:
                carried.add(joint)
        return list(carried)
