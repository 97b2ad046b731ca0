# SPDX-License-Identifier: Apache-2.0
"""A robot port around another one: what lies between a controller and its robot, such as a fault to be tried."""

from __future__ import annotations

from robotskin.model import CommandMode, JointCommand, JointState, PortStatus, RobotPort, SensorReadings


class WrappedPort(RobotPort):
    """A port that does as the one inside does. Derive from it, and override what is to differ.

    It has the joints (n), the interfaces and the sensors of the port inside. What a method of your own raises stops the
    robot, as in any port.

    Args:
        inner: the port inside, such as that of a simulated world or of a real robot.
    """

    def __init__(self, inner: RobotPort) -> None:
        super().__init__(
            inner.joint_count,
            [mode for mode in CommandMode if inner.offers(mode)],
            inner.sensors,
            inner.offers_by_joint,
            inner.smooths_positions,
        )
        self.inner = inner
        """The port inside."""

    def read(self, state: JointState) -> PortStatus:
        """Fills the state (n) as the port inside does: rad, rad/s and Nm, or m, m/s and N."""
        return self.inner.read(state)

    def read_sensors(self, readings: SensorReadings) -> PortStatus:
        """Fills what the sensors of the port inside have measured anew."""
        return self.inner.read_sensors(readings)

    def write(self, command: JointCommand) -> PortStatus:
        """Gives the command (n) to the port inside."""
        return self.inner.write(command)

    def stop(self) -> None:
        """Lets the port inside bring the robot to rest."""
        self.inner.stop()
