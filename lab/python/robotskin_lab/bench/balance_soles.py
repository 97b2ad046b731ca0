# SPDX-License-Identifier: Apache-2.0
"""Balance by the soles' skin: cells in an insole tell the force and the moment at each foot, in place of ankle sensors.

The insole is a Winkler foundation under a stiff foot. It carries most of the load beside the cells, and its foam lags.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from robotskin.apps.balance.foot_tilts import FootTilts
from robotskin.apps.balance.soles import SoleCalibration, SolePressure
from robotskin.apps.balance.standing_soles import SoleFoam, StandingSoles
from robotskin.model import CommandMode, JointCommand, JointState, PortStatus, RobotPort, SensorReadings
from robotskin.robots import Robot
from robotskin.robots.standing import Foot
from robotskin.world import World

Array = NDArray[np.float64]
SHARE = 0.084
"""Of a foot's load that its cells carry; the insole carries the rest."""
SENSORS_AT_M = 0.006 * np.array([(np.cos(a), np.sin(a)) for a in 2 * np.pi / 3 * np.arange(3)])
"""(3, 2) of a cell's force sensors from its middle."""
RANGE_N, COUNT_N, NOISE_COUNTS = 10.0, 10.0 / 1024, 0.5
SCALE, HYSTERESIS, FOAM_HYSTERESIS = 0.02, 0.03, 0.05
"""Error of a sensor's gain, within ±; between the loading and the unloading branch of sensor and foam, of the load."""
BEND = 0.1
"""Chosen: what a cell bears grows with the pressure to a power that is off from 1 by up to this; no calibration knows
it."""
USUAL_N = 450.0
"""The load under which a cell bears its share whatever that power is."""
FOAM_TIME_S = 0.04
"""Time constant of the insole's contact with the floor: foam that the robot's weight presses by some 1.5 mm. On a
harder one a foot that is out of true by half a degree stands on one edge, where no cell is."""
FOAM_N_PER_M, FOAM_LAG_S = 4.1e5, 0.066
"""Of the foam under one sole, as a robot that sways finds it: what a tilt presses, and how late."""
TICK_S = 0.001
SAMPLED_TICKS, LATE_TICKS = 8, 4
"""125 Hz, and the way of a sample through the skin."""
CALIBRATION = 400
"""Poses in which the weight is shifted over a force plate."""
LEAST_N, MOST_N = 150.0, 850.0
BLIND_M = 0.22
"""A sole's length: so far off counts a sample in which the cells feel no load though the robot stands."""


def seven_cells(half_m: tuple[float, float]) -> Array:
    """(7, 2) metres from the sole's middle: three in front, two in the centre, two at the back."""
    x, y = half_m
    front = [(0.7 * x, side * 0.6 * y) for side in (-1, 0, 1)]
    return np.array([*front, *((at * x, side * 0.5 * y) for at in (0.0, -0.7) for side in (-1, 1))])


def tiled(half_m: tuple[float, float]) -> Array:
    """(32, 2) metres: the whole sole in cells, eight by four, the outer ones' middles 11 mm from the edge."""
    x, y = half_m
    return np.array([(a * x, b * y) for a in np.linspace(-0.9, 0.9, 8) for b in np.linspace(-0.83, 0.83, 4)])


class Insole:
    """What the cells of one sole feel of the force on it; its calibration makes the load of that, and so does the
    baseline, a linear map."""

    def __init__(self, cells: Array, half_m: tuple[float, float], generator: np.random.Generator) -> None:
        self._sensors = (cells[:, None, :] + SENSORS_AT_M).reshape(-1, 2)
        self._half = np.array(half_m)
        self._draw = generator
        self._gain = 1 + generator.uniform(-SCALE, SCALE, len(self._sensors))
        self._exponent = 1 + generator.uniform(-BEND, BEND, len(self._sensors))
        self._lagging = np.zeros(len(self._sensors))
        self._pressure = SolePressure(half_m)
        self.calibration = SoleCalibration(self._sensors, half_m, NOISE_COUNTS * COUNT_N, RANGE_N)
        self._calibrate()

    def feel(self, load_n: float, centre_m: Array) -> Array:
        """(n,) newton shown under a load that presses at `centre_m` (2,) from the sole's middle."""
        pressure = load_n * self._pressure.at(self._sensors, self._pressure.plane(centre_m))
        true = SHARE * USUAL_N / len(self._sensors) * (pressure / USUAL_N) ** self._exponent
        # Foam and sensors show less while the load grows and more while it falls.
        play = (HYSTERESIS + FOAM_HYSTERESIS) / 2
        self._lagging = np.clip(self._lagging, (1 - play) * true, (1 + play) * true)
        counts = self._gain * self._lagging / COUNT_N + self._draw.normal(0.0, NOISE_COUNTS, len(true))
        return np.clip(np.round(counts) * COUNT_N, 0.0, RANGE_N)

    def _calibrate(self) -> None:
        """Over loads that wander over the whole sole."""
        felt, loads, centres = [], [], []
        at, load = np.zeros(2), USUAL_N
        for _ in range(CALIBRATION):
            goal = self._draw.uniform(-0.95, 0.95, 2) * self._half
            newton = self._draw.uniform(LEAST_N, MOST_N)
            at, load = at + 0.5 * (goal - at), load + 0.5 * (newton - load)
            felt.append(self.feel(load, at))
            loads.append(load)
            centres.append(at)
        self.calibration.learn(np.array(felt), np.array(loads), np.array(centres))
        # Ridge for sensors that nearly agree.
        a = np.column_stack([np.array(felt), np.ones(CALIBRATION)])
        b = np.array(loads)[:, None] * np.column_stack([np.ones(CALIBRATION), centres])
        self._linear = np.linalg.solve(a.T @ a + 1e-3 * np.eye(a.shape[1]), a.T @ b).T

    def linear(self, felt: Array) -> Array:
        """(3,) newton and newton metres, as of the calibration, by a linear map that learnt from the same poses."""
        return np.asarray(self._linear @ np.append(felt, 1.0))


@dataclass
class _Side:
    foot: Foot
    insole: Insole
    body: int
    shown: Array
    stamp_ns: int = -1


class SolePort(RobotPort):
    """A robot's port whose forces at the feet are what the cells of the soles tell; the rest is the port's own."""

    def __init__(self, world: World, robot: Robot, port: RobotPort, cells: int, seed: int) -> None:
        super().__init__(port.joint_count, [CommandMode.position], port.sensors)
        standing = robot.standing
        assert standing is not None
        self._world, self._port = world, port
        model = world.scene.model
        self._body_of_geom = np.asarray(model.geom_bodyid)
        place = seven_cells if cells == 7 else tiled
        self._sides = [
            _Side(
                foot,
                Insole(place(foot.half_m), foot.half_m, np.random.default_rng([seed, 19, index])),
                int(model.body(foot.link).id),
                np.zeros(3),
            )
            for index, foot in enumerate(standing.feet)
        ]
        for foot in standing.feet:
            model.geom(f"sole_{foot.link}").solref[0] = FOAM_TIME_S
        self._weight_n = float(model.body_subtreemass[model.body_rootid[self._sides[0].body]]) * -model.opt.gravity[2]
        """As the plate of the calibration shows it."""
        foam = SoleFoam(standing.feet[0].half_m, FOAM_N_PER_M, FOAM_LAG_S)
        self._tilts = FootTilts(robot, port.sensors.imus[0])
        self._soles = StandingSoles(foam, self._tilts, self._weight_n)
        self._joints = np.full(port.joint_count, np.nan)
        self._fresh = SensorReadings(port.sensors)
        self._waiting: list[tuple[int, int, Array]] = []
        self._tick = 0
        self.errors_m: list[float] = []
        """Between the true zero-moment point and that of the soles, at each sample; then that of the linear map."""
        self.linear_errors_m: list[float] = []

    def read(self, state: JointState) -> PortStatus:
        """As the port says."""
        status = self._port.read(state)
        self._joints[:] = state.position
        return status

    def write(self, command: JointCommand) -> PortStatus:
        """To the port."""
        return self._port.write(command)

    def stop(self) -> None:
        """Of the port."""
        self._port.stop()

    def read_sensors(self, readings: SensorReadings) -> PortStatus:
        """The port's inertial unit, and forces along z alone at the place where the cells feel them."""
        status = self._port.read_sensors(self._fresh)
        for mine, new in zip(readings.imus, self._fresh.imus, strict=True):
            mine.acceleration, mine.angular_velocity = new.acceleration, new.angular_velocity
            mine.up_from_sensor, mine.stamp_ns = new.up_from_sensor, new.stamp_ns
        self._tilts.hear(self._fresh.imus[0], TICK_S)
        if self._tick % SAMPLED_TICKS == 0:
            self._sample()
        self._tick += 1
        while self._waiting and self._waiting[0][0] <= self._tick:
            _, index, shown = self._waiting.pop(0)
            self._sides[index].shown = shown
            self._sides[index].stamp_ns = self._world.now_ns
        for side, force in zip(self._sides, readings.forces, strict=True):
            load, moment_x, moment_y = side.shown
            x, y, _ = side.foot.sole_m
            force.force = (0.0, 0.0, max(load, 0.0))
            force.moment = (moment_y + y * load, -moment_x - x * load, 0.0)
            force.stamp_ns = side.stamp_ns
        return status

    def _sample(self) -> None:
        poses = [self._world.scene.data.body(side.foot.link) for side in self._sides]
        turns = [pose.xmat.reshape(3, 3)[:2, :2] for pose in poses]
        middles = [
            pose.xpos[:2] + turn @ np.array(side.foot.sole_m[:2])
            for pose, turn, side in zip(poses, turns, self._sides, strict=True)
        ]
        true = [self._true_load(side) for side in self._sides]
        felt = [side.insole.feel(*one) for side, one in zip(self._sides, true, strict=True)]
        by_cells = [side.insole.calibration.load(one) for side, one in zip(self._sides, felt, strict=True)]
        unsure = [side.insole.calibration.unsure(one) for side, one in zip(self._sides, felt, strict=True)]
        told = self._soles.loads(np.array(by_cells), np.array(unsure), self._joints, SAMPLED_TICKS * TICK_S)
        for index, shown in enumerate(told):
            self._waiting.append((self._tick + LATE_TICKS, index, shown))
        true_loads = np.array([[load, *(load * centre)] for load, centre in true])
        if true_loads[:, 0].sum() > LEAST_N:
            linear = np.array([side.insole.linear(one) for side, one in zip(self._sides, felt, strict=True)])
            point = _pressed_at(true_loads, middles, turns)
            for found, errors_m in ((told, self.errors_m), (linear, self.linear_errors_m)):
                felt_all = found[:, 0].sum() > LEAST_N
                off = np.linalg.norm(_pressed_at(found, middles, turns) - point) if felt_all else BLIND_M
                errors_m.append(float(off))

    def _true_load(self, side: _Side) -> tuple[float, Array]:
        """Newton on a sole, and the middle of it from the sole's own, in metres."""
        data = self._world.scene.data
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


def _pressed_at(loads: Array, middles: list[Array], turns: list[Array]) -> Array:
    """(2,) of the floor: where both soles' loads (2, 3) press together; middles (2,) and turns (2, 2) of each sole."""
    moments = [load[0] * middle + turn @ load[1:] for load, middle, turn in zip(loads, middles, turns, strict=True)]
    return np.asarray(sum(moments) / loads[:, 0].sum())
