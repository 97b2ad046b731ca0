"""A task cycle that runs behaviours by name and changes between them and their goals while the robot moves."""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike, NDArray

from robotskin._core.control import (
    CartesianTask,
    Fusion,
    JointTask,
    QuadraticLimits,
    SkinCartesianTask,
    SkinReactionTask,
    StackEntry,
    Task,
)
from robotskin._core.model import CommandMode, JointCommand, JointState, RobotModel
from robotskin._core.robot import GuardReport, SkinSource, TaskCycle, TaskCycleGains
from robotskin._core.skin import SkinModel, SkinState, SkinTorque
from robotskin.control.behaviour import Behaviour, behaviour
from robotskin.control.primitive import Goal, JointGoal, primitive
from robotskin.control.task_library import TaskLibrary
from robotskin.errors import InputError
from robotskin.robots.gains import GainSet


class Controller:
    """Control of one robot; it takes the place of a `SkinCycle` wherever one runs.

    Requests may come from any one thread, `step` from another.

    Args:
        robot: n joints.
        skin: N cells.
        gains: the robot's gain file.
        start: the behaviour to begin with, by name or made by hand.

    Raises:
        UnknownNameError: no such behaviour, task or gain set. GainError, ModelError, ControlError, GuardError: gains,
            robot and skin that do not fit together.
    """

    def __init__(
        self, robot: RobotModel, skin: SkinModel, gains: GainSet, start: str | Behaviour = "skin_compliance"
    ) -> None:
        self.robot, self.gains = robot, gains
        self.library = TaskLibrary(robot, skin)
        self._limits = QuadraticLimits.of(robot)
        cycle = gains.cycle_gains(robot, skin)
        own = TaskCycleGains(cycle.skin, cycle.resolver)
        own.touch_bandwidth_hz, own.fade_s = cycle.skin_bandwidth_hz, cycle.fade_s
        self.behaviour, self.tasks = self._made(start)
        self.cycle = TaskCycle(
            robot, skin, own, gains.guard_limits(robot), self._entries(), self.behaviour.fusion, quadratic=self._limits
        )

    # ---- What it is to do ----

    def use(self, wanted: str | Behaviour) -> dict[str, Task]:
        """Change to a behaviour, by name or made by hand; returns its tasks by name. The torque does not jump."""
        self.behaviour, self.tasks = self._made(wanted)
        self.cycle.request_stack(self._entries(), self.behaviour.fusion, quadratic=self._limits)
        return self.tasks

    def go(self, goal: Goal) -> None:
        """Reach a goal: the primitive generator chooses the behaviour. Nothing changes if the goal is refused."""
        chosen = primitive(goal)
        before = (self.behaviour, self.tasks)
        if chosen.behaviour != self.behaviour:
            self.behaviour, self.tasks = self._made(chosen.behaviour)
        try:
            if chosen.reference is not None:
                self.set_reference(chosen.reference)
        except Exception:
            self.behaviour, self.tasks = before
            raise
        if self.tasks is not before[1]:
            self.cycle.request_stack(self._entries(), self.behaviour.fusion, quadratic=self._limits)

    def set_reference(self, reference: ArrayLike) -> None:
        """Give the behaviour's tasks their reference: (n) rad for joint tasks, (4, 4) metres for Cartesian ones.

        Raises InputError if the behaviour has no task that takes it, ControlError for what lies outside of limits.
        """
        values = np.ascontiguousarray(reference, dtype=float)
        kind = CartesianTask if values.ndim == 2 else JointTask
        followers = [task for task in self.tasks.values() if isinstance(task, kind)]
        if not followers:
            raise InputError(
                f"reference of shape {values.shape}: {self.behaviour.name} has no task that follows it, its tasks are "
                f"{', '.join(self.tasks)}"
            )
        for task in followers:
            task.request_reference(values)

    def _made(self, wanted: str | Behaviour) -> tuple[Behaviour, dict[str, Task]]:
        found = behaviour(wanted) if isinstance(wanted, str) else wanted
        chosen = self.gains.choose(found.name)
        return found, {name: self.library.make(name, chosen) for name in found.tasks}

    def _entries(self) -> list[StackEntry]:
        return [StackEntry(self.tasks[name], level) for name, level in self.behaviour.tasks.items()]

    # ---- The cycle ----

    def step(
        self,
        joints: JointState,
        skin: SkinState,
        now_ns: int,
        command: JointCommand,
        own_torque: SkinTorque | None = None,
    ) -> GuardReport:
        """One period; see `TaskCycle.step`. Tasks sum the cells' forces themselves; `own_torque` is not used."""
        return self.cycle.step(joints, skin, now_ns, command)

    def request_run(self, run: bool) -> None:
        """Start, or stop smoothly."""
        self.cycle.request_run(run)

    def request_mode(self, mode: CommandMode) -> None:
        """Command the robot by position, velocity or torque."""
        self.cycle.request_mode(mode)

    def request_skin_task(self, on: bool) -> None:
        """Let tasks feel the skin, or not."""
        self.cycle.request_skin_task(on)

    def request_skin_source(self, source: SkinSource) -> None:
        """Only the host's sums: raises InputError for those of the skin."""
        if source is not SkinSource.host:
            raise InputError(f"skin source {source.name}: tasks of behaviours sum the cells' forces on the host")

    def request_patch_mask(self, patch: int, masked: bool) -> bool:
        """Let a patch contribute nothing; False if there is no such patch."""
        return self.cycle.request_patch_mask(patch, masked)

    def request_goal(self, goal: NDArray[np.float64]) -> None:
        """Move the joints there if the behaviour has a reference for them, else change to one that has."""
        if any(isinstance(task, JointTask) for task in self.tasks.values()):
            self.set_reference(goal)
        else:
            self.go(JointGoal(goal))

    @property
    def report(self) -> GuardReport:
        """What the guard decided last."""
        return self.cycle.report

    @property
    def host_skin_torque(self) -> NDArray[np.float64]:
        """(n) Nm that the behaviour's skin tasks ask for; zero where it has none."""
        asked = np.zeros(self.robot.joint_count)
        for task in self.tasks.values():
            if isinstance(task, SkinReactionTask | SkinCartesianTask):
                asked += task.torque
        return asked

    @property
    def fusion(self) -> Fusion:
        """How the tasks are fused."""
        return self.behaviour.fusion
