# SPDX-License-Identifier: Apache-2.0
"""The port of a Franka Research 3, over the vendor's pylibfranka in a process of its own."""

from __future__ import annotations

import multiprocessing
import time
from typing import TYPE_CHECKING, Any

import numpy as np

from robotskin.franka.arm_process import serve
from robotskin.franka.condition import TOLD, FrankaCondition
from robotskin.franka.errors import FrankaError
from robotskin.franka.messages import ArmCommand, ArmState, Floats, Mailboxes
from robotskin.franka.set_point import JOINTS
from robotskin.model import CommandMode, JointCommand, JointState, PortStatus, RobotDynamics, RobotPort

if TYPE_CHECKING:
    from robotskin.robots import Robot

START_S = 60.0
REST_S = 3.0


class FrankaPort(RobotPort):
    """Seven joints of a Franka, ready to be read. Effort is what its torque sensors tell (tau_J).

    Args:
        robot: what it moves: 7 joints. Its gravity is taken out of torques, since the controller adds the arm's own.
        address: of the controller.
        within_s: for the first state. silent_s: without a state, after which the robot counts as gone.
        realtime: the process runs before all that are not real-time, and libfranka demands it of the kernel.

    Raises FrankaError: another count of joints, nothing at the address, another software, no library.
    """

    def __init__(
        self, robot: Robot, address: str, *, within_s: float = 5.0, silent_s: float = 0.1, realtime: bool = False
    ) -> None:
        if robot.joint_count != JOINTS:
            hand = ": lock the joints of its hand" if robot.joint_count > JOINTS else ": is it this robot?"
            raise FrankaError(
                f"robot {address}: a Franka has {JOINTS} joints, found {robot.joint_count} of {robot.name}{hand}"
            )
        super().__init__(JOINTS, [CommandMode.position, CommandMode.velocity, CommandMode.torque])
        self.address, self.silent_s = address, silent_s
        self._dynamics = RobotDynamics(robot.core)
        self._boxes = Mailboxes()
        self._newest: ArmState | None = None
        self._unread, self._closed, self._recoveries, self._why = False, False, 0, ""
        context: Any = multiprocessing.get_context("spawn")
        self._pipe, theirs = context.Pipe()
        self._process = context.Process(
            target=serve, args=(address, realtime, self._boxes.memory.name, theirs), daemon=True
        )
        self._process.start()
        theirs.close()
        try:
            self._await_first(within_s)
        except BaseException:
            self._end_process()
            raise

    def _await_first(self, within_s: float) -> None:
        try:
            good, told = self._pipe.recv() if self._pipe.poll(START_S) else (False, "its process does not start")
        except EOFError:
            good, told = False, "its process has ended"
        if not good:
            raise FrankaError(f"robot {self.address}: {told}")
        ends = time.monotonic() + within_s
        while self.condition is not FrankaCondition.ready:
            if time.monotonic() > ends:
                raise FrankaError(f"robot {self.address}: takes no commands: {self.condition_told}")
            time.sleep(0.002)

    # ---- In the cycle ----

    def read(self, state: JointState) -> PortStatus:
        """As any port."""
        self._look()
        newest = self._newest
        if newest is None or self._silent(newest):
            return PortStatus.disconnected
        if not self._unread:
            return PortStatus.no_new_state
        self._unread = False
        state.position, state.velocity, state.effort = newest.position, newest.velocity, newest.effort
        state.stamp_ns = newest.stamp_ns
        return PortStatus.ok

    def write(self, command: JointCommand) -> PortStatus:
        """As any port."""
        value, mode = np.asarray(command.value), command.mode
        if mode is None or not self.offers(mode) or len(value) != JOINTS or not np.isfinite(value).all():
            return PortStatus.refused
        condition = self.condition
        if condition is not FrankaCondition.ready:
            return PortStatus.disconnected if condition is FrankaCondition.disconnected else PortStatus.refused
        if mode is CommandMode.torque:
            assert self._newest is not None
            self._dynamics.update(self._newest.position, np.zeros(JOINTS))
            value = value - self._dynamics.gravity_torque
        self._tell(mode, value)
        return PortStatus.ok

    def stop(self) -> None:
        """As any port."""
        if not self._closed:
            self._tell(None, np.zeros(JOINTS))

    # ---- Of the port ----

    @property
    def condition(self) -> FrankaCondition:
        """Why it takes commands, or does not."""
        self._look()
        if self._newest is None or self._silent(self._newest):
            return FrankaCondition.disconnected
        return self._newest.condition

    @property
    def condition_told(self) -> str:
        """The same in words that say what to do, with what the controller said; empty where it takes commands."""
        told = TOLD[self.condition]
        try:
            while self._pipe.poll():
                self._why = str(self._pipe.recv()[1])
        except (EOFError, OSError):
            self._why = "its process has ended: connect anew"
        return f"{told} ({self._why})" if told and self._why else told

    def recover(self) -> None:
        """A person starts it anew: a reflex is over. Nothing moves."""
        self._recoveries += 1
        self.stop()

    def close(self) -> None:
        """Bring the robot to rest and end the connection for good."""
        if self._closed:
            return
        self._closed = True
        assert self._boxes.commands is not None
        self._boxes.commands.put(
            ArmCommand(time.monotonic_ns(), None, self._recoveries, np.zeros(JOINTS), ends=True).numbers()
        )
        self._process.join(REST_S)
        self._end_process()

    def _end_process(self) -> None:
        self._closed = True
        if self._process.is_alive():
            self._process.kill()
            self._process.join()
        self._pipe.close()
        self._boxes.close()

    def _look(self) -> None:
        numbers = None if self._boxes.states is None else self._boxes.states.take()
        if numbers is not None:
            self._newest, self._unread = ArmState.of(numbers), True

    def _silent(self, newest: ArmState) -> bool:
        return self._closed or time.monotonic_ns() - newest.stamp_ns > self.silent_s * 1e9

    def _tell(self, mode: CommandMode | None, value: Floats) -> None:
        assert self._boxes.commands is not None
        self._boxes.commands.put(ArmCommand(time.monotonic_ns(), mode, self._recoveries, value).numbers())
