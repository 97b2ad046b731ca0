# SPDX-License-Identifier: Apache-2.0
"""The process that speaks with a Franka's controller: states out and commands in, a thousand times a second.

It alone imports the vendor's library. The robot's own limit ends a motion 20 ms after the last message, so this
process lets nothing wait: it meets the host in mailboxes.
"""

from __future__ import annotations

import contextlib
import gc
import importlib
import os
import time
from multiprocessing.connection import Connection
from typing import Any

import numpy as np

from robotskin.franka.condition import FrankaCondition, condition_of
from robotskin.franka.messages import ArmCommand, ArmState, Floats, Mailboxes
from robotskin.franka.set_point import JOINTS, SetPoint, led_torque
from robotskin.model import CommandMode

LIFE_S = 0.02
CYCLE_S, LONGEST_CYCLE_S = 0.001, 0.005
RETRY_S = 0.2
HOLD_STIFFNESS = np.array([600.0, 600.0, 600.0, 600.0, 250.0, 150.0, 50.0])
HOLD_DAMPING = np.array([50.0, 50.0, 50.0, 50.0, 30.0, 25.0, 15.0])
"""Nm/rad and Nm s/rad with which torques bring the robot to rest."""
SLOW_RAD_S, SLOW_S, HOLD_S = 0.02, 0.05, 2.0
FIFO_PRIORITY = 20


class Arm:
    """A robot behind libfranka. library: the module pylibfranka; raises its exceptions where nothing is there."""

    def __init__(self, library: Any, address: str, realtime: bool, boxes: Mailboxes) -> None:
        self._library, self._address, self._boxes = library, address, boxes
        ways = library.RealtimeConfig
        self._realtime = ways.kEnforce if realtime else ways.kIgnore
        self.robot: Any = library.Robot(address, self._realtime)
        self._control: Any = None
        self._mode = CommandMode.position
        self._command = ArmCommand(0, None, 0, np.zeros(JOINTS))
        self._held = False  # the controller ended a motion: no further one before the host has stopped
        self._set_point = SetPoint(np.zeros(JOINTS))
        self._torque = np.zeros(JOINTS)
        self._hold: Floats | None = None
        self._holding_s = self._slow_s = 0.0
        self._last = ArmState(0, FrankaCondition.busy, *np.zeros((3, JOINTS)))
        self.failure = ""
        """Why the last motion or connection ended; empty: as it was told to."""

    @property
    def ended(self) -> bool:
        """Whether the host wants no more, and the robot is at rest."""
        return self._command.ends and self._control is None

    @property
    def moving(self) -> bool:
        """Whether a motion is under way; it ends by itself where the host says nothing."""
        return self._control is not None

    def cycle(self) -> None:
        """One message of the controller and its answer."""
        try:
            if self.robot is None:
                self._reconnect()
                return
            seconds = CYCLE_S
            if self._control is None:
                state = self.robot.read_once()
            else:
                state, gone = self._control.readOnce()
                seconds = min(max(gone.to_sec(), CYCLE_S), LONGEST_CYCLE_S)
            self._tell(state)
            self._hear()
            if self._control is None:
                self._begin(state)
            else:
                self._go_on(state, seconds)
        except RuntimeError as error:  # each exception of libfranka is one
            self._failed(error)

    # ---- Host ----

    def _tell(self, state: Any) -> None:
        condition = condition_of(state.robot_mode.name)
        if self._held and condition is FrankaCondition.ready:
            condition = FrankaCondition.reflex
        arrays = (np.array(one) for one in (state.q, state.dq, state.tau_J))
        self._last = ArmState(time.monotonic_ns(), condition, *arrays)
        assert self._boxes.states is not None
        self._boxes.states.put(self._last.numbers())

    def _hear(self) -> None:
        assert self._boxes.commands is not None
        numbers = self._boxes.commands.take()
        if numbers is None:
            return
        before, self._command = self._command, ArmCommand.of(numbers)
        if self._command.mode is None:
            self._held = False
        if self._command.recoveries != before.recoveries and self._control is None:
            self.robot.automatic_error_recovery()

    @property
    def _wanted(self) -> CommandMode | None:
        """What a command that lives asks for."""
        lives = time.monotonic_ns() - self._command.stamp_ns < LIFE_S * 1e9
        return self._command.mode if lives and not self._held else None

    # ---- Controller ----

    def _begin(self, state: Any) -> None:
        wanted = self._wanted
        if wanted is None or self._last.condition is not FrankaCondition.ready:
            return
        self._mode, self._set_point = wanted, SetPoint(state.q_d)
        self._torque, self._hold = np.zeros(JOINTS), None
        servo = self._library.ControllerMode.JointImpedance
        if wanted is CommandMode.position:
            self._control = self.robot.start_joint_position_control(servo)
        elif wanted is CommandMode.velocity:
            self._control = self.robot.start_joint_velocity_control(servo)
        else:
            self._control = self.robot.start_torque_control()

    def _go_on(self, state: Any, seconds: float) -> None:
        aim = self._command.value if self._wanted is self._mode else None
        if self._mode is CommandMode.torque:
            told, finished = self._torques(aim, seconds)
        else:
            if aim is None:
                self._set_point.towards_velocity(np.zeros(JOINTS), seconds)
            elif self._mode is CommandMode.position:
                self._set_point.towards_position(aim, seconds)
            else:
                self._set_point.towards_velocity(aim, seconds)
            finished = aim is None and self._set_point.at_rest
            if self._mode is CommandMode.position:
                told = self._library.JointPositions(self._set_point.position.tolist())
            else:
                told = self._library.JointVelocities(self._set_point.velocity.tolist())
        told.motion_finished = finished
        control = self._control
        if finished:
            self._control = None
        control.writeOnce(told)

    def _torques(self, aim: Floats | None, seconds: float) -> tuple[Any, bool]:
        finished = False
        if aim is not None:
            self._hold = None
        else:
            velocity = self._last.velocity
            if self._hold is None:
                self._hold, self._holding_s, self._slow_s = self._last.position, 0.0, 0.0
            aim = HOLD_STIFFNESS * (self._hold - self._last.position) - HOLD_DAMPING * velocity
            self._holding_s += seconds
            self._slow_s = self._slow_s + seconds if np.abs(velocity).max() < SLOW_RAD_S else 0.0
            finished = self._slow_s > SLOW_S or self._holding_s > HOLD_S
        self._torque = led_torque(self._torque, aim, seconds)
        return self._library.Torques(self._torque.tolist()), finished

    def _failed(self, error: RuntimeError) -> None:
        self.failure = str(error)
        self._control, self._held = None, True
        if isinstance(error, self._library.NetworkException):
            self.robot = None
            gone = (self._last.position, self._last.velocity, self._last.effort)
            self._last = ArmState(time.monotonic_ns(), FrankaCondition.disconnected, *gone)
            assert self._boxes.states is not None
            self._boxes.states.put(self._last.numbers())

    def _reconnect(self) -> None:
        assert self._boxes.commands is not None
        numbers = self._boxes.commands.take()
        if numbers is not None:
            self._command = ArmCommand.of(numbers)
        time.sleep(RETRY_S)
        self.robot = self._library.Robot(self._address, self._realtime)


def serve(address: str, realtime: bool, memory: str, pipe: Connection) -> None:
    """Run until the host ends it or is gone; tells through the pipe whether it could begin, and why a motion ended."""
    parent = os.getppid()
    boxes = Mailboxes(memory)
    try:
        try:
            library = importlib.import_module("pylibfranka")
        except ImportError as error:
            pipe.send((False, f"{error.name} is not installed: pip install 'robotskin[franka]'"))
            return
        if realtime:
            os.sched_setscheduler(0, os.SCHED_FIFO, os.sched_param(FIFO_PRIORITY))
        try:
            arm = Arm(library, address, realtime, boxes)
        except (RuntimeError, OSError) as error:
            pipe.send((False, str(error)))
            return
        pipe.send((True, ""))
        gc.freeze()
        gc.disable()
        told = ""
        while not arm.ended and (os.getppid() == parent or arm.moving):
            arm.cycle()
            if arm.failure != told:
                told = arm.failure
                with contextlib.suppress(OSError):
                    pipe.send((False, told))
    except OSError as error:
        with contextlib.suppress(OSError):
            pipe.send((False, error.strerror or str(error)))
    finally:
        boxes.close()
