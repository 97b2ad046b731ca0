# SPDX-License-Identifier: Apache-2.0
"""Balance by the soles' skin: cells of an insole tell force and moment at each foot, in place of ankle sensors."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from robotskin.apps.balance.foot_tilts import FootTilts
from robotskin.apps.balance.insole import FOAM_LAG_S, FOAM_N_PER_M, FOAM_TIME_S, Insole, seven_cells, tiled
from robotskin.apps.balance.standing_soles import SoleFoam, StandingSoles
from robotskin.model import JointState, PortStatus, RobotPort, SensorReadings
from robotskin.ports import WrappedPort
from robotskin.robots import Robot
from robotskin.robots.standing import Foot
from robotskin.world import World

Array = NDArray[np.float64]
TICK_S = 0.001
SAMPLED_TICKS, LATE_TICKS = 8, 4
"""125 Hz, and the way of a sample through the skin."""


@dataclass
class Side:
    """One foot: `shown` (3,) N and Nm, as its port tells it now."""

    foot: Foot
    insole: Insole
    body: int
    shown: Array
    stamp_ns: int = -1


class SolePort(WrappedPort):
    """A robot's port whose forces at the feet are what the cells of the soles tell; the rest is the port's own.

    Args:
        world: that simulates the robot; the contact of its soles with the floor becomes soft foam.
        robot: the model; one that stands.
        port: of the robot, with its inertial unit.
        cells: of each sole, 7 or 32. seed: of the insoles and their sensors.
    """

    def __init__(self, world: World, robot: Robot, port: RobotPort, cells: int, seed: int) -> None:
        super().__init__(port)
        standing = robot.standing
        assert standing is not None
        self.world = world
        model = world.scene.model
        self._body_of_geom = np.asarray(model.geom_bodyid)
        place = seven_cells if cells == 7 else tiled
        self.sides = [
            Side(
                foot,
                Insole(place(foot.half_m), foot.half_m, np.random.default_rng([seed, 19, index])),
                int(model.body(foot.link).id),
                np.zeros(3),
            )
            for index, foot in enumerate(standing.feet)
        ]
        for foot in standing.feet:
            model.geom(f"sole_{foot.link}").solref[0] = FOAM_TIME_S
        self._weight_n = float(model.body_subtreemass[model.body_rootid[self.sides[0].body]]) * -model.opt.gravity[2]
        """As the plate of the calibration shows it."""
        foam = SoleFoam(standing.feet[0].half_m, FOAM_N_PER_M, FOAM_LAG_S)
        self._tilts = FootTilts(robot, port.sensors.imus[0])
        self._soles = StandingSoles(foam, self._tilts, self._weight_n)
        self._joints = np.full(port.joint_count, np.nan)
        self._fresh = SensorReadings(port.sensors)
        self._waiting: list[tuple[int, int, Array]] = []
        self._tick = 0

    def read(self, state: JointState) -> PortStatus:
        """As the port says."""
        status = super().read(state)
        self._joints[:] = state.position
        return status

    def read_sensors(self, readings: SensorReadings) -> PortStatus:
        """The port's inertial unit, and forces along z alone at the place where the cells feel them."""
        status = super().read_sensors(self._fresh)
        for mine, new in zip(readings.imus, self._fresh.imus, strict=True):
            mine.acceleration, mine.angular_velocity = new.acceleration, new.angular_velocity
            mine.up_from_sensor, mine.stamp_ns = new.up_from_sensor, new.stamp_ns
        self._tilts.hear(self._fresh.imus[0], TICK_S)
        if self._tick % SAMPLED_TICKS == 0:
            self._sample()
        self._tick += 1
        while self._waiting and self._waiting[0][0] <= self._tick:
            _, index, shown = self._waiting.pop(0)
            self.sides[index].shown = shown
            self.sides[index].stamp_ns = self.world.now_ns
        for side, force in zip(self.sides, readings.forces, strict=True):
            load, moment_x, moment_y = side.shown
            x, y, _ = side.foot.sole_m
            force.force = (0.0, 0.0, max(load, 0.0))
            force.moment = (moment_y + y * load, -moment_x - x * load, 0.0)
            force.stamp_ns = side.stamp_ns
        return status

    def _sample(self) -> None:
        true = [self._true_load(side) for side in self.sides]
        felt = [side.insole.feel(*one) for side, one in zip(self.sides, true, strict=True)]
        by_cells = [side.insole.calibration.load(one) for side, one in zip(self.sides, felt, strict=True)]
        unsure = [side.insole.calibration.unsure(one) for side, one in zip(self.sides, felt, strict=True)]
        doubt = [side.insole.calibration.doubt(one) for side, one in zip(self.sides, felt, strict=True)]
        told = self._soles.loads(
            np.array(by_cells), np.array(unsure), np.array(doubt), self._joints, SAMPLED_TICKS * TICK_S
        )
        for index, shown in enumerate(told):
            self._waiting.append((self._tick + LATE_TICKS, index, shown))
        self._sampled(true, felt, told)

    def _sampled(self, true: Sequence[tuple[float, Array]], felt: Sequence[Array], told: Array) -> None:
        """For what compares: after each sample, the true load of each sole and its middle, what its cells feel, and
        (2, 3) what is told of it."""

    def _true_load(self, side: Side) -> tuple[float, Array]:
        """Newton on a sole, and the middle of it from the sole's own, in metres."""
        data = self.world.scene.data
        contact = data.contact
        address = np.asarray(contact.efc_address)[: data.ncon]
        on_foot = (self._body_of_geom[np.asarray(contact.geom)[: data.ncon]] == side.body).any(axis=1) & (address >= 0)
        if not on_foot.any():
            return 0.0, np.zeros(2)
        normal = np.asarray(data.efc_force)[address[on_foot]]
        total = float(normal.sum())
        if total <= 0:
            return 0.0, np.zeros(2)
        pose = data.body(side.foot.link)
        local = (np.asarray(contact.pos)[: data.ncon][on_foot] - pose.xpos) @ pose.xmat.reshape(3, 3)
        centre = normal @ local[:, :2] / total - np.array(side.foot.sole_m[:2])
        return total, np.clip(centre, -0.95 * np.array(side.foot.half_m), 0.95 * np.array(side.foot.half_m))
