"""A session whose controller runs behaviours by name."""

from __future__ import annotations

from pathlib import Path
from typing import Any

from robotskin._core.control import Fusion
from robotskin._core.model import RobotModel
from robotskin._core.robot import Condition, Reason, SafetyState
from robotskin._core.skin import SkinModel
from robotskin.apps.session import Session
from robotskin.control import Behaviour, Controller
from robotskin.control.body_limits import BodyLimits
from robotskin.control.state_log import write_state_log
from robotskin.errors import InputError
from robotskin.layout import Layout
from robotskin.robots import Robot
from robotskin.selfconfig.map.sensory_motor_map import SensoryMotorMap


class BehaviourSession(Session):
    """A skinned robot that does what behaviours and goals say; see `Session` for the other arguments.

    Args:
        robot: the robot, whose gains must name a gain set for the behaviour.
        layout: its skin.
        behaviour: to begin with, by name or made by hand.
        seed: repeats the run.
        fusion: how tasks are fused, instead of the behaviours' own way.
        self_collision: behaviours by name keep bodies apart and joints off their limits, too.
        skin_map: reactions to touch are recalled from this map, without a kinematic model.
        body_limits: limits of contact, at which the guard stops the robot.
        fault_file: where the last second before a fault is written (CSV); None: nowhere.

    Raises:
        UnknownNameError, InputError, BodyLimitsError: what does not fit the robot and its skin.
    """

    controller: Controller

    def __init__(
        self,
        robot: Robot,
        layout: Layout,
        behaviour: str | Behaviour = "skin_compliance",
        seed: int = 1,
        *,
        fusion: Fusion | None = None,
        self_collision: bool = False,
        skin_map: SensoryMotorMap | None = None,
        body_limits: BodyLimits | None = None,
        fault_file: str | Path | None = None,
        **options: Any,
    ) -> None:
        self._start, self._fusion = behaviour, fusion
        self._body = robot if self_collision else None
        self._skin_map, self._body_limits = skin_map, body_limits
        self.fault_file = None if fault_file is None else Path(fault_file)
        if self.fault_file is not None and not self.fault_file.absolute().parent.is_dir():
            raise InputError(f"fault file {self.fault_file}: there is no folder {self.fault_file.absolute().parent}")
        self.fault = ""
        """Why a fault stopped the robot last, as far as one did."""
        self._written = ""
        self._unwritten = False
        super().__init__(robot, layout, seed, **options)

    def make_cycle(self, robot: RobotModel, skin: SkinModel) -> Controller:
        """The controller of all behaviours."""
        limits = None
        if self._body_limits is not None:
            limits = self._body_limits.for_skin(self.layout, self.gains.values["skin"]["force_silent_n"])
        self.controller = Controller(
            robot,
            skin,
            self.gains,
            self._start,
            fusion=self._fusion,
            body=self._body,
            skin_map=self._skin_map,
            body_limits=limits,
        )
        return self.controller

    def step(self) -> None:
        """One control period; where it ends in a fault, the last second is written once the robot is at rest."""
        before = self.state
        super().step()
        report = self.controller.report
        if before is not SafetyState.stopped and report.state is SafetyState.stopped and report.reason != Reason.asked:
            self.fault = "; ".join(part for part in (report.text, self.controller.task_error) if part)
            self._unwritten, self._written = self.fault_file is not None, ""
        if self._unwritten and report.conditions & Condition.at_rest.value:
            self._write_fault()

    def _why_not_running(self) -> str:
        return "; ".join(part for part in (super()._why_not_running(), self.controller.task_error) if part)

    def shut_down(self) -> None:
        """Stop the robot and bring it to rest, whatever happened before."""
        try:
            if self._unwritten:
                self._write_fault()
        finally:
            super().shut_down()

    def _write_fault(self) -> None:
        self._unwritten = False
        if self.fault_file is None:
            return
        try:
            write_state_log(self.fault_file, self.controller.cycle.log, self.robot.joint_names, self.fault)
            self._written = f"its last second is in {self.fault_file}"
        except OSError as error:  # The robot is being stopped, which no full disk may prevent.
            self._written = f"its last second could not be written to {self.fault_file}: {error}"

    @property
    def fault_told(self) -> str:
        """The last fault in one sentence and where its last second is, for people; empty where there was none."""
        if not self.fault:
            return ""
        return "; ".join(part for part in (f"a fault stopped the robot: {self.fault}", self._written) if part)

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
        if not self.controller.takes_own_torque:
            self.set_source("host")

    @property
    def source_refused(self) -> str:
        """Why `set_source` refuses "skin" at present; empty where it does not."""
        return super().source_refused or self.controller.own_torque_refused
