# SPDX-License-Identifier: Apache-2.0
"""A port around another one shows what the other shows, and a fault in it reaches the controller of a session."""

from collections.abc import Sequence

import numpy as np
import pytest

from robotskin.cycle import SafetyState
from robotskin.layout import finished
from robotskin.model import (
    CommandMode,
    JointCommand,
    JointState,
    PortSensors,
    PortStatus,
    RobotPort,
    SensorPlace,
    SensorReadings,
)
from robotskin.ports import WrappedPort
from robotskin.robots import load
from robotskin.session import Session

PLACES = PortSensors([SensorPlace("unit", "base")], [SensorPlace("left", "foot"), SensorPlace("right", "foot")])


class Told(RobotPort):
    """Tells numbers of its own, and keeps what it is told."""

    def __init__(self, modes: Sequence[CommandMode], by_joint: bool = False, smooths: bool = False) -> None:
        super().__init__(2, modes, PLACES, by_joint, smooths)
        self.values: list[np.ndarray] = []
        self.stops = 0

    def read(self, state: JointState) -> PortStatus:
        state.position, state.stamp_ns = np.array([0.25, -0.5]), 7
        return PortStatus.ok

    def read_sensors(self, readings: SensorReadings) -> PortStatus:
        readings.forces[1].force = (1.0, 2.0, 3.0)
        return PortStatus.no_new_state

    def write(self, command: JointCommand) -> PortStatus:
        self.values.append(np.array(command.value))
        return PortStatus.refused

    def stop(self) -> None:
        self.stops += 1


@pytest.mark.parametrize("modes", [[CommandMode.position], [CommandMode.velocity, CommandMode.torque]])
@pytest.mark.parametrize(("by_joint", "smooths"), [(False, True), (True, False)])
def test_it_offers_what_the_port_inside_offers(modes: list[CommandMode], by_joint: bool, smooths: bool) -> None:
    port = WrappedPort(Told(modes, by_joint, smooths))
    assert [mode for mode in CommandMode if port.offers(mode)] == modes
    assert (port.offers_by_joint, port.smooths_positions, port.joint_count) == (by_joint, smooths, 2)
    assert [place.name for place in port.sensors.imus + port.sensors.forces] == ["unit", "left", "right"]


def test_it_passes_on_what_is_read_and_written() -> None:
    inner = Told([CommandMode.position])
    port, state, readings = WrappedPort(inner), JointState(2), SensorReadings(PLACES)
    assert port.read(state) is PortStatus.ok
    assert (state.position.tolist(), state.stamp_ns) == ([0.25, -0.5], 7)
    assert port.read_sensors(readings) is PortStatus.no_new_state
    assert readings.forces[1].force == [1.0, 2.0, 3.0]
    command = JointCommand(CommandMode.position, 2)
    command.value = np.array([0.1, 0.2])
    assert port.write(command) is PortStatus.refused
    assert [value.tolist() for value in inner.values] == [[0.1, 0.2]]
    port.stop()
    assert inner.stops == 1


class Deaf(WrappedPort):
    """Hears nothing of the robot while it is deaf."""

    deaf = False

    def read(self, state: JointState) -> PortStatus:
        return PortStatus.no_new_state if self.deaf else super().read(state)


def test_a_session_runs_through_a_port_of_its_user(seed: int) -> None:
    """What a plain session does, to the bit; and its guard stops the robot once the fault is there."""

    def pushed(**options) -> Session:
        session = Session(load("ur5"), finished("ur5"), seed=seed, link="in process", **options)
        session.boot()
        session.world.push(cell=135, force_n=8.0)
        session.run(0.3)
        return session

    plain, faulty = pushed(), pushed(port=Deaf)
    assert isinstance(faulty.port, Deaf)
    assert faulty.state is SafetyState.running
    assert np.array_equal(faulty.joints.position, plain.joints.position)
    faulty.port.deaf = True
    faulty.run(0.2)
    assert faulty.state is SafetyState.stopped
    assert "joint" in faulty.why_not_running()
