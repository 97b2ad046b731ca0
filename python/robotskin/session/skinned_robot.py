# SPDX-License-Identifier: Apache-2.0
"""A robot in its skin between two ends of any kind: a robot port and a skin input, real, replayed or simulated."""

from __future__ import annotations

import threading
import time
from collections.abc import Iterable, Mapping
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from robotskin.choices import INTERFACES, member
from robotskin.control import Behaviour, Controller
from robotskin.control.body_limits import BodyLimits
from robotskin.cycle import SafetyState, SkinSource, safety_table
from robotskin.errors import RobotskinError
from robotskin.layout import Layout
from robotskin.loop import LoopReport, SkinLoop
from robotskin.model import CommandMode, JointCommand, JointState, RobotPort
from robotskin.robots import Robot
from robotskin.robots.gains import GainSet, gains_of
from robotskin.selfconfig.map.sensory_motor_map import SensoryMotorMap
from robotskin.session.fault_file import FaultFile
from robotskin.session.interfaces import ByLimb, modes_by_joint, told
from robotskin.session.waiting_for import waits_for
from robotskin.skin import Health, SkinInput, SkinState
from robotskin.tasks import Fusion

PERIOD_S = 0.001


class SessionError(RobotskinError):
    """A session that cannot go on; the message says at which step and why."""


def require_robot_and_layout(robot: object, layout: object) -> None:
    """Raise SessionError for what is neither, saying how to get one."""
    if not isinstance(robot, Robot):
        raise SessionError(f"robot is {_told(robot)}: give a Robot, such as robotskin.robots.load('ur5')")
    if not isinstance(layout, Layout):
        raise SessionError(
            f"layout is {_told(layout)}: give a Layout, such as robotskin.layout.finished('ur5') or Layout.load(FILE)"
        )


def _told(value: object) -> str:
    return repr(value) if isinstance(value, str) else f"a {type(value).__name__}"


class SkinnedRobot:
    """Controller and loop of one robot (`SkinLoop`), and what may be asked of them.

    Args:
        robot: n joints.
        layout: its skin, N cells, as far as it is known.
        port: what moves the robot: n joints. Derive from `RobotPort` for a robot of your own.
        skin: where the N cells' samples come from. Derive from `SkinInput` for a skin of your own.
        behaviour: to begin with, by name or made by hand.
        interface: one that the port offers, by member or name; or of each limb or joint (`interfaces.py`).
        control: the robot as the controller takes it to be, such as with identified masses; by default as it is.
        gains: of this robot; by default those of its name that come with the project, else made.
        fusion: how tasks are fused, instead of the behaviours' own way.
        self_collision: behaviours by name keep bodies apart and joints off their limits, too.
        skin_map: reactions to touch are recalled from this map, without a kinematic model.
        body_limits: limits of contact, at which the guard stops the robot.
        fault_file: where the last second before a fault is written (CSV); None: nowhere.
        fusion_ends_s: see `Controller`; 0 wherever a run is to be repeated.

    Raises:
        LoopError: port, input and robot of different counts, an interface that the port does not offer.
        UnknownNameError: no gains of that name, no such behaviour or interface. InputError, BodyLimitsError, GainError,
            ModelError, ControlError: what does not fit the robot and its skin.
    """

    def __init__(
        self,
        robot: Robot,
        layout: Layout,
        port: RobotPort,
        skin: SkinInput,
        behaviour: str | Behaviour = "skin_compliance",
        *,
        interface: CommandMode | str | ByLimb = CommandMode.position,
        control: Robot | None = None,
        gains: GainSet | None = None,
        fusion: Fusion | None = None,
        self_collision: bool = False,
        skin_map: SensoryMotorMap | None = None,
        body_limits: BodyLimits | None = None,
        fault_file: str | Path | None = None,
        fusion_ends_s: float = 0.0,
    ) -> None:
        require_robot_and_layout(robot, layout)
        self.fault_file = FaultFile(fault_file)
        self.robot, self.layout, self.port = robot, layout, port
        self.gains = gains or gains_of(robot)
        self.gains.require_fit(robot.core)
        self.home = self.gains.home
        limits = None
        if body_limits is not None:
            limits = body_limits.for_skin(layout, self.gains.values["skin"]["force_silent_n"])
        self.controller = Controller(
            (control or robot).core,
            layout.skin_model(),
            self.gains,
            behaviour,
            fusion=fusion,
            body=robot if self_collision else None,
            skin_map=skin_map,
            body_limits=limits,
            fusion_ends_s=fusion_ends_s,
        )
        self.loop = SkinLoop(port, skin, self.controller.cycle)
        self.controller.joints = self.loop.joints
        self.interface = ""
        """How the robot is commanded, in words: a name of `interfaces`."""
        self._by_limb: dict[str, list[CommandMode]] = {}
        self.source = "host"
        """Which side sums the torque of touch, by name."""
        self.skin_on = True
        self.left_out: frozenset[int] = frozenset()
        """Cells that contribute nothing, by `leave_out`."""
        self.locked = ""
        """Why nothing but `unlock` lets it start; empty: it may."""
        self._locking = threading.Lock()
        self.set_interface(interface)

    def __repr__(self) -> str:
        return (
            f"<{type(self).__name__} of {self.robot.name}: {len(self.layout)} cells, {self.behaviour}, "
            f"{self.interface} interface, {self.state.name}>"
        )

    # ---- The loop ----

    def tick(self, now_ns: int) -> LoopReport:
        """One control period at host time `now_ns`, from samples to command; see `SkinLoop.step`.

        Raises LoopError for what a port or an input written in Python did amiss; the robot was told to stop before.
        """
        report = self.loop.step(now_ns)
        guard = self.loop.guard
        self.fault_file.watch(guard, self.controller.task_error)
        self.fault_file.write_at_rest(guard, self.controller.cycle, self.robot.joint_names)
        return report

    def tick_for(self, seconds: float) -> LoopReport:
        """Tick in real time, once a period on the host's monotonic clock. What is late is not caught up with."""
        due = time.monotonic()
        ends = due + seconds
        report = self.loop.report
        while time.monotonic() < ends:
            report = self.tick(time.monotonic_ns())
            due = max(due + PERIOD_S, time.monotonic())
            time.sleep(max(due - time.monotonic(), 0.0))
        return report

    def start(self) -> None:
        """Let the controller move the robot as soon as all its conditions hold (`why_not_running`)."""
        with self._locking:
            if not self.locked:
                self.loop.request_run(True)

    def stop(self) -> None:
        """Stop smoothly, then hold."""
        self.loop.request_run(False)

    def lock(self, why: str) -> None:
        """Stop smoothly, and let nothing start the robot before `unlock`; any thread may."""
        with self._locking:
            self.locked = why
            self.loop.request_run(False)

    def unlock(self) -> None:
        """Let `start` start it again: for those that stand beside the robot."""
        with self._locking:
            self.locked = ""

    def why_not_running(self) -> str:
        """What the controller waits for, or why it stopped; empty while it runs."""
        if self.locked:
            return self.locked
        if self.state in (SafetyState.running, SafetyState.degraded):
            return ""
        report = self.controller.report
        if report.state is not SafetyState.ready:
            return "; ".join(part for part in (report.text, self.controller.task_error) if part)
        needed = next(row[1] for row in safety_table() if row[0] is SafetyState.ready and row[3] is SafetyState.running)
        missing = waits_for(needed & ~report.conditions)
        return "; ".join(part for part in (missing, self.controller.task_error) if part)

    # ---- What may be asked of it ----

    def set_interface(self, interface: CommandMode | str | ByLimb) -> None:
        """Command the robot by position, velocity or torque from the next step on, or each limb by its own.

        Raises UnknownNameError, LoopError for one that the port does not offer, and InputError where by limb a joint is
        left out.
        """
        if isinstance(interface, Mapping):
            modes = modes_by_joint(self.robot.core, interface)
            self._by_limb = {told(self.robot.core, modes): modes}
            interface = next(iter(self._by_limb))
        if interface in self._by_limb:
            self.loop.request_modes(self._by_limb[str(interface)])
            self.interface = str(interface)
            return
        chosen = member("interface", CommandMode, interface)
        self.loop.request_mode(chosen)
        self.interface = str(chosen.name)

    @property
    def interfaces(self) -> tuple[str, ...]:
        """Names of the interfaces that the robot offers, and of the last one by limb."""
        offered = tuple(name for name in INTERFACES if self.port.offers(CommandMode[name]))
        return offered + tuple(name for name in self._by_limb if name not in offered)

    def set_source(self, source: SkinSource | str) -> None:
        """Let the host or the skin itself compute the torque of the skin task, from the next step on.

        Raises SessionError for "skin" where the cells compute none.
        """
        chosen = member("source", SkinSource, source)
        if chosen is SkinSource.skin and not self.computes_torques:
            raise SessionError(self.source_refused)
        self.controller.request_skin_source(chosen)
        self.source = str(chosen.name)

    @property
    def computes_torques(self) -> bool:
        """Whether the cells have been told how to compute their torques."""
        return False

    @property
    def source_refused(self) -> str:
        """Why `set_source` refuses "skin" at present; empty where it does not."""
        if not self.computes_torques:
            return "the cells have not been told how to compute torques"
        return self.controller.skin_computed_torque_refused

    def set_skin(self, on: bool) -> None:
        """Let touch move the robot, or not."""
        self.controller.request_skin(on)
        self.skin_on = on

    @property
    def behaviour(self) -> str:
        """What the robot does, by name."""
        return self.controller.behaviour.name

    @property
    def behaviours(self) -> dict[str, str]:
        """What `set_behaviour` takes, and what each means."""
        return {name: one.meaning for name, one in self.controller.behaviours.items()}

    def set_behaviour(self, name: str) -> None:
        """Do something else from the next step on; the torque does not jump. Raises UnknownNameError."""
        self.controller.use(name)
        if not self.controller.takes_skin_computed_torque:
            self.set_source(SkinSource.host)

    def mask_patch(self, patch: int, masked: bool) -> None:
        """Let the cells of a patch contribute nothing to the skin task."""
        self.controller.request_patch_mask(patch, masked)

    def leave_out(self, cells: Iterable[int]) -> None:
        """Let these cells, and no others, contribute nothing and count as not alive, such as ill ones; it fades.

        Raises SessionError for a cell that there is not.
        """
        wanted = {int(cell) for cell in cells}
        for cell in sorted(wanted):
            if not 0 <= cell < len(self.layout):
                raise SessionError(f"cell {cell}: there are cells 0 to {len(self.layout) - 1}")
        for cell in wanted - self.left_out:
            self.controller.cycle.request_cell_mask(cell, True)
        for cell in self.left_out - wanted:
            self.controller.cycle.request_cell_mask(cell, False)
        self.left_out = frozenset(wanted)

    # ---- What is known of it ----

    @property
    def state(self) -> SafetyState:
        """Of the controller."""
        return self.controller.report.state

    @property
    def fault(self) -> str:
        """Why a fault stopped the robot last; empty where none did."""
        return self.fault_file.fault

    @property
    def fault_told(self) -> str:
        """The last fault in one sentence and where its last second is, for people; empty where there was none."""
        return self.fault_file.told

    @property
    def alive(self) -> int:
        """Cells alive."""
        return int(self.living.sum())

    @property
    def skin(self) -> SkinState:
        """What the skin felt in the last tick; the arrays share its memory."""
        return self.loop.skin

    @property
    def joints(self) -> JointState:
        """Measured in the last tick."""
        return self.loop.joints

    @property
    def command(self) -> JointCommand:
        """Of the last tick."""
        return self.loop.command

    @property
    def living(self) -> NDArray[np.bool_]:
        """(N,) cells that are alive, left out or not."""
        return np.asarray(np.asarray(self.skin.health) == int(Health.alive))

    @property
    def fresh(self) -> NDArray[np.bool_]:
        """(N,) cells whose values count: alive, and not left out. Values of cells that are not alive are their last."""
        fresh = self.living
        fresh[list(self.left_out)] = False
        return fresh

    def cell_readings_n(self) -> NDArray[np.float64]:
        """(N, 3) newton of the force sensors of each cell; a cell that is not fresh feels nothing."""
        return np.where(self.fresh[:, None], np.asarray(self.skin.normal_force, dtype=float), 0.0)

    def cell_forces_n(self) -> NDArray[np.float64]:
        """(N,) newton that each cell feels; one that is not fresh feels nothing."""
        return np.asarray(self.cell_readings_n().sum(axis=1))

    def cell_nearness(self) -> NDArray[np.float64]:
        """(N,) 0 to 1, how near something is to each cell; a cell that is not fresh sees nothing."""
        return np.where(self.fresh, np.asarray(self.skin.proximity, dtype=float), 0.0)

    def cell_distances_m(self) -> NDArray[np.float64]:
        """(N,) metres to what each cell sees; one that is not fresh sees nothing: infinity."""
        return np.where(self.fresh, np.asarray(self.skin.distance, dtype=float), np.inf)

    def felt_force_n(self, threshold_n: float = 0.1) -> float:
        """Newton at the driver: the sum over cells that feel more than the threshold; NaN where no cell is alive."""
        force = np.asarray(self.skin.normal_force).sum(axis=1)
        if not self.living.any():
            return float("nan")
        return float(force[self.living & (force > threshold_n)].sum())
