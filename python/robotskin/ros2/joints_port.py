# SPDX-License-Identifier: Apache-2.0
"""A robot under ros2_control behind the port of any robot: joint states in, commands to forward controllers out.

A thread of the port hears the states and counts the life of a command; the cycle meets it under a lock that is held for
the time of one message.
"""

from __future__ import annotations

import threading
import time

import numpy as np
from cyclonedds.core import DDSException

from robotskin.model import CommandMode, JointCommand, JointState, PortStatus, RobotDynamics, RobotPort
from robotskin.robots import Robot
from robotskin.ros2.dds import DdsNode, RawWriter
from robotskin.ros2.errors import Ros2Error
from robotskin.ros2.joint_messages import COMMANDS, Floats, commands_bytes
from robotskin.ros2.joint_states import WAIT_S, JointStates, StampedJoints
from robotskin.ros2.joints_name import JointsName
from robotskin.ros2.topic import Topic

LIFE_S = 0.02
SILENT_S = 0.1
BEYOND_S, BEYOND = 0.1, 0.01
"""How far from the joint a position may stay commanded after a stop: its way in so many seconds, and rad (m)."""
STIFFNESS, DAMPING = 400.0, 40.0
"""1/s² and 1/s with which torques hold the robot after a stop, scaled by its inertia."""


class Ros2Port(RobotPort):
    """n joints of a robot under ros2_control, ready to be read.

    Positions, velocities and efforts go to forward controllers, which keep the last command for ever: so this program
    stops the robot by itself `LIFE_S` after the last command, but if its machine dies, only positions stand still.

    Args:
        robot: what it moves. named: topics, domain, interface.
        within_s: for the first state. silent_s: without a state, after which the robot counts as gone.

    Raises Ros2Error: no states, states of other joints, no controller that takes commands, another commander.
    """

    def __init__(self, robot: Robot, named: JointsName, *, within_s: float = 5.0, silent_s: float = SILENT_S) -> None:
        super().__init__(robot.joint_count, list(named.commands))
        self.named = named
        self._node = DdsNode(named.domain, named.interface)
        self._topics = {mode: Topic(name, COMMANDS) for mode, name in named.commands.items()}
        self._writers = {mode: self._node.writer(topic, 1, 0.0) for mode, topic in self._topics.items()}
        self._listeners = {topic.name: self._node.raw_reader(topic) for topic in self._topics.values()}
        self._states = JointStates(self._node, named, robot.joint_names)
        ends = time.monotonic() + within_s
        self.rate_hz = self._states.open(within_s)
        self._await_controllers(ends)
        order = named.order or tuple(robot.joint_names)
        self._to_controller = np.array([robot.joint_names.index(name) for name in order], dtype=np.intp)
        self._effort_limit = np.asarray(robot.effort_limit)
        self._dynamics = RobotDynamics(robot.core)
        self.silent_s = silent_s
        """Without a state, after which the robot counts as gone."""
        self._lock = threading.Lock()
        self._mode: CommandMode | None = None  # of a command that lives
        self._stopped_in: CommandMode | None = None
        self._value = np.zeros(robot.joint_count)
        self._hold = np.zeros(robot.joint_count)
        self._written_ns = self._read_ns = 0
        self._closing = threading.Event()
        self._thread = threading.Thread(target=self._run, name="joints of ROS 2", daemon=True)
        self._thread.start()

    def _await_controllers(self, ends: float) -> None:
        for mode, writer in self._writers.items():
            topic = self._topics[mode].name
            while writer.readers < 2 and time.monotonic() < ends:  # its own listener is one
                time.sleep(0.01)
            if writer.readers < 2:
                raise Ros2Error(f"{topic}: nothing takes commands there: is its forward controller active?")
            if (talkers := self._listeners[topic].talkers) > 1:
                raise Ros2Error(f"{topic}: found {talkers - 1} other programs that command the robot; end them first")

    # ---- In the cycle ----

    def read(self, state: JointState) -> PortStatus:
        """As any port."""
        newest = self._states.newest
        assert newest is not None
        if self._silent(newest):
            return PortStatus.disconnected
        if newest.stamp_ns <= self._read_ns:
            return PortStatus.no_new_state
        self._read_ns = state.stamp_ns = newest.stamp_ns
        state.position, state.velocity = newest.joints.position, newest.joints.velocity
        state.effort = newest.joints.effort
        return PortStatus.ok

    def write(self, command: JointCommand) -> PortStatus:
        """As any port."""
        value, mode = np.asarray(command.value), command.mode
        newest = self._states.newest
        assert newest is not None
        wrong = len(value) != self.joint_count or not np.isfinite(value).all()
        if mode is None or not self.offers(mode) or wrong:
            return PortStatus.refused
        if self._closing.is_set() or self._silent(newest):
            return PortStatus.disconnected
        with self._lock:
            self._mode, self._value, self._written_ns = mode, value.copy(), time.monotonic_ns()
            self._stopped_in = None
            return PortStatus.ok if self._send(mode, value, newest) else PortStatus.disconnected

    def stop(self) -> None:
        """As any port."""
        with self._lock:
            self._rest()

    # ---- Of the port ----

    def close(self) -> None:
        """Stop the robot and hear no more; after torques nothing holds it but the last one, of its own weight."""
        if self._closing.is_set():
            return
        self.stop()
        if self._stopped_in is CommandMode.torque:
            time.sleep(0.3)
        self._closing.set()
        self._thread.join()
        with self._lock:
            newest = self._states.newest
            if self._stopped_in is CommandMode.torque and newest is not None:
                self._send(CommandMode.torque, self._weight(newest), newest)
            self._writers.clear()
            self._listeners.clear()
        self._states.close()
        self._node.close()

    def _silent(self, newest: StampedJoints) -> bool:
        return time.monotonic_ns() - newest.arrival_ns > self.silent_s * 1e9

    def _run(self) -> None:
        while not self._closing.is_set():
            came = self._hear()
            with self._lock:
                newest = self._states.newest
                assert newest is not None
                dead = time.monotonic_ns() - self._written_ns > LIFE_S * 1e9 or self._silent(newest)
                if self._mode is not None and dead:
                    self._rest()
                elif self._stopped_in is CommandMode.torque and (came or self._silent(newest)):
                    self._keep_by_torque(newest)

    def _hear(self) -> int:
        try:
            return self._states.hear()
        except DDSException:  # SAFETY: what is not heard grows old, which stops the robot below
            time.sleep(WAIT_S)
            return 0

    def _rest(self) -> None:
        """Stop what was commanded last; once, until another command comes."""
        if self._mode is None:
            return
        newest = self._states.newest
        assert newest is not None
        mode, self._mode = self._mode, None
        self._stopped_in = mode
        position, velocity = newest.joints.position, newest.joints.velocity
        if mode is CommandMode.position:
            beyond = BEYOND_S * np.abs(velocity) + BEYOND
            self._send(mode, np.clip(self._value, position - beyond, position + beyond), newest)
        elif mode is CommandMode.velocity:
            self._send(mode, np.zeros_like(velocity), newest)
        else:
            self._hold = position.copy()
            self._keep_by_torque(newest)

    def _keep_by_torque(self, newest: StampedJoints) -> None:
        joints = newest.joints
        torque = self._weight(newest)
        if not self._silent(newest):
            pull = STIFFNESS * (self._hold - joints.position) - DAMPING * joints.velocity
            torque = torque + np.asarray(self._dynamics.mass_matrix) @ pull
        limit = self._effort_limit
        self._send(CommandMode.torque, np.clip(torque, -limit, limit), newest)

    def _weight(self, newest: StampedJoints) -> Floats:
        self._dynamics.update(newest.joints.position, np.zeros(self.joint_count))
        return np.array(self._dynamics.gravity_torque)

    def _send(self, mode: CommandMode, value: Floats, newest: StampedJoints) -> bool:
        if mode is CommandMode.torque and self.named.carries_weight:
            value = value - self._weight(newest)
        writer: RawWriter = self._writers[mode]
        try:
            writer.send(commands_bytes(self._topics[mode], value[self._to_controller]))
        except DDSException:
            return False
        return True
