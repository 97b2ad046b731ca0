# SPDX-License-Identifier: Apache-2.0
"""Parts of a standing robot fail, one at a time, and its chest is pushed all the same."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from robotskin.model import PortStatus, RobotPort, SensorReadings
from robotskin.ports import WrappedPort
from robotskin_lab.bench.balance_rig import CHEST, ROBOT, Law, StandingRig, drawn_cells, ramp
from robotskin_lab.bench.balance_search import Outcome, largest_stood
from robotskin_lab.bench.progress import tell

BACKWARD = (-1.0, 0.0, 0.0)
HELD_N, HELD_S = 25.0, 1.2
FIRST_N, MOST_N = 83.0, 200.0
STALL_S = 0.020
RESTS_S = 0.5


class FaultyPort(WrappedPort):
    """A port some of whose sensors may fail while the robot stands."""

    def __init__(self, port: RobotPort) -> None:
        super().__init__(port)
        self.lost_force: int | None = None
        """The foot whose force is not heard any more."""
        self.stuck_imu = False
        """The inertial unit says what it said last, with new stamps."""
        self._fresh = SensorReadings(port.sensors)

    def read_sensors(self, readings: SensorReadings) -> PortStatus:
        """What has not failed."""
        status = super().read_sensors(self._fresh)
        for index, (mine, new) in enumerate(zip(readings.forces, self._fresh.forces, strict=True)):
            if index != self.lost_force:
                mine.force, mine.moment, mine.stamp_ns = new.force, new.moment, new.stamp_ns
        for unit, fresh in zip(readings.imus, self._fresh.imus, strict=True):
            if not self.stuck_imu:
                unit.acceleration, unit.angular_velocity = fresh.acceleration, fresh.angular_velocity
                unit.up_from_sensor = fresh.up_from_sensor
            unit.stamp_ns = fresh.stamp_ns
        return status


def lose_foot(rig: StandingRig) -> None:
    """The force of the left foot is not heard any more."""
    assert isinstance(rig.port, FaultyPort)
    rig.port.lost_force = 0


def stick_imu(rig: StandingRig) -> None:
    """The inertial unit repeats itself."""
    assert isinstance(rig.port, FaultyPort)
    rig.port.stuck_imu = True


def kill_chest(rig: StandingRig) -> None:
    """The group of cells that feels a push on the chest is not heard any more."""
    assert rig.cell is not None
    rig.skin.dead = rig.layout.group == rig.layout.group[rig.cell]


def stall(rig: StandingRig) -> None:
    """The control thread does nothing for 20 ms."""
    rig.world.step(STALL_S)


FAULTS: dict[str, Callable[[StandingRig], None]] = {
    "lost_foot": lose_foot,
    "dead_group": kill_chest,
    "stuck_imu": stick_imu,
    "stall": stall,
}
"""By what ends the names of their figures."""


def rig_before_fault(seed: int) -> StandingRig:
    """A robot that stands, a plate before a drawn cell of its chest, and a port whose sensors may fail."""
    cell = drawn_cells(seed, 1, CHEST, np.array(BACKWARD))[0]
    return StandingRig(ROBOT, Law("compliant"), seed, cell, BACKWARD, port=FaultyPort)


def fault_figures(seed: int) -> dict[str, float]:
    """What each fault leaves of a robot whose chest is pushed.

    fault_stands_F: 1 where it bears 25 N, which begin after the fault F, and does not fall. fault_stops_F: 1 where the
    guard stopped it meanwhile, and it stood in balance. fault_runs_again_F: 1 where it runs at the end, started again
    if it was stopped. fault_ramp_F_n: the largest slow push that it stands, the fault before it.
    """
    figures = {}
    for name, fail in FAULTS.items():
        rig = failed(seed, fail)
        figures[f"fault_stands_{name}"] = float(rig.push(lambda t: HELD_N * min(t / 0.2, 1.0), HELD_S))
        figures[f"fault_stops_{name}"] = float(rig.stopped)
        runs_again(rig)
        figures[f"fault_runs_again_{name}"] = float(not rig.fallen and not rig.stopped)

        def pushed(size: float, fail: Callable[[StandingRig], None] = fail) -> Outcome:
            tried = failed(seed, fail)
            stands = tried.push(*ramp(size))
            return Outcome(stands, tried.stopped)

        found = largest_stood(pushed, FIRST_N, MOST_N, halvings=0)
        figures[f"fault_ramp_{name}_n"] = found.largest
        tell(f"balance: seed {seed}, {name}: stands {found.largest:.0f} N, stopped in {found.stops} pushes")
    return figures


def failed(seed: int, fail: Callable[[StandingRig], None]) -> StandingRig:
    """A robot that stands and whose part has failed a moment ago."""
    rig = rig_before_fault(seed)
    fail(rig)
    rig.run(0.1)
    return rig


def runs_again(rig: StandingRig) -> None:
    """The push ends; a stopped robot is started again once it is at rest."""
    rig.world.thing("plate").push(-2.0 * rig.direction)
    if rig.stopped:
        rig.start_again()
    rig.run(RESTS_S)
