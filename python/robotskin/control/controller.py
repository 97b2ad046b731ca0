# SPDX-License-Identifier: Apache-2.0
"""A task cycle that runs behaviours by name and changes between them and their goals while the robot moves."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import replace

import numpy as np
from numpy.typing import ArrayLike, NDArray

from robotskin.control.behaviour import BEHAVIOURS, PRESS, Behaviour, behaviour
from robotskin.control.goal import Goal, JointGoal, LimbGoals
from robotskin.control.goal_bounds import Wanted, require_stands
from robotskin.control.limb_primitive import limb_primitive
from robotskin.control.primitive import primitive
from robotskin.control.task_library import TaskLibrary
from robotskin.cycle import BodyLimits, GuardReport, SkinSource, TaskCycle
from robotskin.errors import InputError
from robotskin.model import CommandMode, JointCommand, JointState, RobotModel
from robotskin.robots import Robot
from robotskin.robots.gains import ChosenGains, GainSet
from robotskin.selfconfig.map.sensory_motor_map import SensoryMotorMap
from robotskin.skin import SkinModel, SkinState, SkinTorque
from robotskin.tasks import (
    CartesianTask,
    ForceTask,
    Fusion,
    JointTask,
    MapSkinTask,
    PythonTask,
    QuadraticLimits,
    SkinCartesianTask,
    SkinReactionTask,
    StackEntry,
    Task,
)

PRESSES = "force"
"""What the names of tasks that press begin with: their references are no place."""


class Controller:
    """Control of one robot: its task cycle, and the behaviours that it runs.

    Requests may come from any one thread, `step` from another.

    Args:
        robot: n joints.
        skin: N cells.
        gains: the robot's gain file.
        start: the behaviour to begin with, by name or made by hand.
        fusion: how behaviours by name are fused, instead of their own way.
        body: the robot's surfaces; behaviours by name then keep off joint limits and self-collision, too.
        skin_map: a learnt map, from which behaviours by name then recall their reaction to touch, instead of from the
            kinematic model (`Behaviour.with_map`).
        body_limits: limits of contact, at which the guard stops the robot (`robotskin.control.body_limits`).
        fusion_ends_s: after which a clock ends the fusion of a tick, counted in `cycle.fusion_counts`; 0: none does.

    Raises:
        UnknownNameError: no such behaviour, task or gain set. InputError: a map that does not fit. GainError,
            ModelError, ControlError, GuardError: gains, robot and skin that do not fit together.
    """

    def __init__(
        self,
        robot: RobotModel,
        skin: SkinModel,
        gains: GainSet,
        start: str | Behaviour = "skin_compliance",
        *,
        fusion: Fusion | None = None,
        body: Robot | None = None,
        skin_map: SensoryMotorMap | None = None,
        body_limits: BodyLimits | None = None,
        fusion_ends_s: float = 0.0,
    ) -> None:
        self.robot, self.gains = robot, gains
        self.library = TaskLibrary(robot, skin, body, skin_map)
        self.joints: JointState | None = None
        """Where the joints are, by which a robot on feet judges goals of its links; None: not known, as at home."""
        self._fusion = fusion
        self._limits = QuadraticLimits.of(robot)
        own = gains.cycle_gains(robot, skin)
        own.fusion_ends_s = fusion_ends_s
        self.behaviour, self.tasks = self._made(start)
        limits = gains.guard_limits(robot)
        if body_limits is not None:
            limits.body = body_limits
        self.cycle = TaskCycle(robot, skin, own, limits, self._entries(), self.behaviour.fusion, quadratic=self._limits)

    def __repr__(self) -> str:
        return f"<Controller of {self.robot.joint_count} joints: {self.behaviour.name}>"

    # ---- What it is to do ----

    def use(self, wanted: str | Behaviour) -> dict[str, Task]:
        """Change to a behaviour, by name or made by hand; returns its tasks by name. The torque does not jump."""
        made = self._made(wanted)
        self.cycle.request_stack(_entries(*made), made[0].fusion, quadratic=self._limits)
        self.behaviour, self.tasks = made
        return self.tasks

    def go(self, goal: Goal) -> None:
        """Reach a goal: the primitive generator chooses the behaviour. Nothing changes if the goal is refused.

        Raises InputError for what is no goal, and on feet for one out of reach or balance, with the bound;
        UnknownNameError for a limb or link that there is none of, ControlError for joints out of their limits.
        """
        chosen = limb_primitive(goal, self.robot, self._hand_link) if isinstance(goal, LimbGoals) else primitive(goal)
        self._require_stands(
            Wanted(reference, chosen.behaviour.part(name).link, chosen.behaviour.part(name).joints)
            for name, reference in chosen.references.items()
            if not name.startswith(PRESSES)
        )
        before = (self.behaviour, self.tasks)
        other = chosen.behaviour.name != self.behaviour.name or chosen.behaviour.parts or self.behaviour.parts
        if other or not chosen.references.keys() <= self.tasks.keys():
            self.behaviour, self.tasks = self._made(self._as_asked(chosen.behaviour))
        try:
            for name, reference in chosen.references.items():
                task = self.tasks[name]
                if isinstance(task, ForceTask):
                    task.request_force(reference)
                elif isinstance(task, CartesianTask | JointTask):
                    task.request_reference(reference)
        except Exception:
            self.behaviour, self.tasks = before
            raise
        if self.tasks is not before[1]:
            if not self.takes_skin_computed_torque:
                self.cycle.request_skin_source(SkinSource.host)
            self.cycle.request_stack(self._entries(), self.behaviour.fusion, quadratic=self._limits)

    def set_reference(self, reference: ArrayLike) -> None:
        """Give the behaviour's tasks their reference: (n) rad for joint tasks, (4, 4) metres for Cartesian ones.

        Raises InputError if the behaviour has no task that takes it, or for one in which a robot on feet would not
        stand; ControlError for what lies outside of limits.
        """
        values = np.ascontiguousarray(reference, dtype=float)
        kind = CartesianTask if values.ndim == 2 else JointTask
        followers = {name: task for name, task in self.tasks.items() if isinstance(task, kind)}
        if not followers:
            raise InputError(
                f"reference of shape {values.shape}: {self.behaviour.name} has no task that follows it, its tasks are "
                f"{', '.join(self.tasks)}"
            )
        parts = [self.behaviour.part(name) for name in followers]
        self._require_stands(Wanted(values, part.link, part.joints) for part in parts)
        for task in followers.values():
            task.request_reference(values)

    def _require_stands(self, wanted: Iterable[Wanted]) -> None:
        if self.library.feet:
            home = np.asarray(self.gains.home)
            present = home if self.joints is None else np.array(self.joints.position)
            # Before the first tick the base of a robot on feet is not known.
            present = np.where(np.isfinite(present), present, home)
            require_stands(self.robot, [replace(one, link=one.link or self._hand_link) for one in wanted], present)

    @property
    def _hand_link(self) -> str:
        """What Cartesian tasks move unless they are told."""
        return str(self.gains.values["cartesian"]["link"])

    def _made(self, wanted: str | Behaviour) -> tuple[Behaviour, dict[str, Task]]:
        found = self._as_asked(behaviour(wanted)) if isinstance(wanted, str) else wanted
        return found, {name: self.library.make(name, self._chosen(found, name)) for name in found.tasks}

    def _chosen(self, made: Behaviour, task: str) -> ChosenGains:
        """The gains of one of a behaviour's tasks."""
        part = made.part(task)
        joints = tuple(list(self.robot.joint_names).index(joint) for joint in part.joints)
        return replace(self.gains.choose(part.gains), other_link=part.link, joints=joints)

    def _as_asked(self, named: Behaviour) -> Behaviour:
        """The form that a behaviour by name takes for this controller."""
        if self._fusion is not None and named.name in BEHAVIOURS:  # the others need their levels
            named = named.with_fusion(self._fusion)
        if self.library.skin_map is not None and named.name != PRESS.name:  # nothing in it reacts to touch
            named = named.with_map()
        if self.library.body is not None:
            named = named.protected()
        return named.standing() if self.library.feet else named

    def _entries(self) -> list[StackEntry]:
        return _entries(self.behaviour, self.tasks)

    @property
    def behaviours(self) -> dict[str, Behaviour]:
        """Those that `use` takes by name, in the form that they have here."""
        by_map = self.library.skin_map is not None
        return {name: self._as_asked(one) for name, one in BEHAVIOURS.items() if "skin" in one.tasks or not by_map}

    # ---- The cycle ----

    def step(
        self,
        joints: JointState,
        skin: SkinState,
        now_ns: int,
        command: JointCommand,
        skin_computed_torque: SkinTorque | None = None,
    ) -> GuardReport:
        """One period; see `TaskCycle.step`. `skin_computed_torque`: what the skin has computed itself, if it does."""
        self.joints = joints
        return self.cycle.step(joints, skin, now_ns, command, skin_computed_torque)

    def request_run(self, run: bool) -> None:
        """Start, or stop smoothly."""
        self.cycle.request_run(run)

    def request_mode(self, mode: CommandMode) -> None:
        """Command the robot by position, velocity or torque."""
        self.cycle.request_mode(mode)

    def request_skin(self, on: bool) -> None:
        """Let tasks feel the skin, or not."""
        self.cycle.request_skin(on)

    def request_skin_source(self, source: SkinSource) -> None:
        """Whose torque the skin task contributes. Raises InputError for the skin's where the behaviour has none."""
        if source is not SkinSource.host and self.skin_computed_torque_refused:
            raise InputError(f"skin source {source.name}: {self.skin_computed_torque_refused}")
        self.cycle.request_skin_source(source)

    @property
    def takes_skin_computed_torque(self) -> bool:
        """Whether the behaviour has a task that can take the skin's own torque: one that feels all cells."""
        return any(
            isinstance(task, SkinReactionTask) and not self.behaviour.part(name).joints
            for name, task in self.tasks.items()
        )

    @property
    def skin_computed_torque_refused(self) -> str:
        """Why the behaviour cannot take the skin's own torque; empty where it can."""
        if self.takes_skin_computed_torque:
            return ""
        fits = ", ".join(name for name, one in self.behaviours.items() if "skin" in one.tasks) or "none by a map"
        return f"{self.behaviour.name} sums the cells' forces on the host; the skin's own torque is taken by {fits}"

    def request_patch_mask(self, patch: int, masked: bool) -> bool:
        """Let a patch contribute nothing; False if there is no such patch."""
        return self.cycle.request_patch_mask(patch, masked)

    def request_goal(self, goal: NDArray[np.float64]) -> None:
        """Move the joints to (n) rad or m; a behaviour without a reference for them is changed to one that has."""
        if any(isinstance(task, JointTask) for task in self.tasks.values()):
            self.set_reference(goal)
        else:
            self.go(JointGoal(goal))

    @property
    def intervention_counts(self) -> NDArray[np.uint64]:
        """(5, n) cycles in which each `Limit` of each joint changed a running command."""
        return self.cycle.intervention_counts

    @property
    def report(self) -> GuardReport:
        """What the guard decided last."""
        return self.cycle.report

    @property
    def task_error(self) -> str:
        """What tasks written in Python raised in the last tick, by name; empty where none did."""
        failed = {name: task.error for name, task in self.tasks.items() if isinstance(task, PythonTask) and task.error}
        return "; ".join(f"task {name}: {error.splitlines()[-1]}" for name, error in failed.items())

    @property
    def host_skin_torque(self) -> NDArray[np.float64]:
        """(n) Nm that the behaviour's skin tasks ask for; zero where it has none."""
        asked = np.zeros(self.robot.joint_count)
        for task in self.tasks.values():
            if isinstance(task, SkinReactionTask):
                asked += task.host_torque
            elif isinstance(task, SkinCartesianTask | MapSkinTask):
                asked += task.torque
        return asked

    @property
    def skin_torque(self) -> NDArray[np.float64]:
        """(n) Nm that the behaviour's reaction to touch contributes, by either source, unfiltered; zero without one."""
        used = np.zeros(self.robot.joint_count)
        for task in self.tasks.values():
            if isinstance(task, SkinReactionTask):
                used += task.used_torque
        return used

    @property
    def skin_source_share(self) -> float:
        """1: all of the reaction to touch is the skin's own torque, 0: all is the host's."""
        shares = [task.source_share for task in self.tasks.values() if isinstance(task, SkinReactionTask)]
        return shares[0] if shares else 0.0

    @property
    def fusion(self) -> Fusion:
        """How the tasks are fused."""
        return self.behaviour.fusion


def _entries(behaviour: Behaviour, tasks: dict[str, Task]) -> list[StackEntry]:
    return [StackEntry(tasks[name], level) for name, level in behaviour.tasks.items()]
