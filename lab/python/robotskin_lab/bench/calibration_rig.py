# SPDX-License-Identifier: Apache-2.0
"""Cells with force sensors as they are made are pressed: sensors of the imperfect world, and a robot's torques."""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from robotskin.calibration.force_sensors import OFFSET, PARAMETERS, Array, shares
from robotskin.calibration.post import AtPost
from robotskin.calibration.presses import Presses
from robotskin.firmware import CHANNELS
from robotskin.layout import Layout
from robotskin.robots import Robot
from robotskin.simulator import Imperfections, SensorModels

PLACES_M = 0.010 * np.array([[0.0, 0.0], [0.0, 1.0], [-0.87, -0.5], [0.87, -0.5]])
LEVELS_N = tuple(np.linspace(0.5, 8.0, 16))
FORCE_STEP_N = next(step for name, _, _, step, _ in CHANNELS if name == "force_1")
STEP_S = 0.05
REST_S = 1.0
PLACE_ERROR_M, PROBE_ERROR = 0.001, 0.01
LEVER_ERROR = 0.01


def raw(**changed: float) -> Imperfections:
    """The imperfect world with force sensors as they are made."""
    found = Imperfections()
    found.force_scale, found.force_offset_n, found.force_cross_sensor = 0.2, 0.2, 0.05
    found.force_offset_counts = 0.0
    for name, value in changed.items():
        setattr(found, name, value)
    return found


@dataclass
class Rig:
    """N cells and what is really true of them."""

    layout: Layout
    seed: int
    world: Imperfections = field(default_factory=raw)

    def __post_init__(self) -> None:
        self.draw = np.random.default_rng([self.seed, 53])
        self.cells = len(self.layout)
        self.sensors = SensorModels(self.cells, self.world, self.seed)
        self.soft = self.world.force_crosstalk
        self.beside = [[int(cell) for cell in row if cell >= 0] for row in self.layout.neighbours[:, :, 0]]
        self.time_s = 0.0
        self.rest_n = self.at_rest()
        """(N, 3) what was shown untouched when it was looked at last, newton."""
        self.mounted_s = 0.0
        """Of all presses against the post."""

    def read(self, force_n: Array, passed_s: float) -> Array:
        """(N, 3) newton that the sensors show once so much time has passed under forces (N, 3)."""
        self.time_s += passed_s
        return _read(self.sensors, self.time_s, force_n)

    def at_rest(self) -> Array:
        """(N, 3) newton, the mean of a second in which nothing touches the skin."""
        nothing = np.zeros((self.cells, 3))
        return np.mean([self.read(nothing, STEP_S) for _ in range(round(REST_S / STEP_S))], axis=0)

    def pressed(self, cell: int, force_n: float, place_m: Array) -> Array:
        """(N, 3) what each sensor feels: the soft layer carries some over to the neighbours."""
        force = np.zeros((self.cells, 3))
        share = shares(place_m[None])[0]
        force[cell] = (1 - self.soft * len(self.beside[cell])) * force_n * share
        force[self.beside[cell]] = self.soft * force_n / 3
        return force

    def true_parameters(self) -> Array:
        """(N, 12) from sensors of the same draw without noise, hysteresis, creep and drift.

        A pre-load is there whatever presses, so it is a part of the offset.
        """
        still = raw(force_hysteresis=0, force_creep=0, force_noise_counts=0, drift_counts=0)
        found = np.empty((self.cells, PARAMETERS))
        step = 4.0
        base = np.full((self.cells, 3), 2.0)
        sensors = SensorModels(self.cells, still, self.seed)
        at_base = _read(sensors, 0.05, base)
        columns = np.stack([(_read(sensors, 0.1, base + step * axis) - at_base) / step for axis in np.eye(3)], axis=2)
        gain = np.diagonal(columns, axis1=1, axis2=2)
        found[:, :3] = gain
        cross = columns / gain[:, :, None]
        found[:, 6:] = cross.reshape(-1, 9)[:, ~np.eye(3, dtype=bool).ravel()]
        found[:, OFFSET] = at_base - np.einsum("nij,nj->ni", columns, base)
        return found

    # ---- Presses ----

    def by_probe(self, cell: int) -> Presses:
        """A probe of known force goes to four places of the cell, in and out."""
        errors = self.draw.normal(0, PLACE_ERROR_M, 2), 1 + self.draw.normal(0, PROBE_ERROR)
        self.rest_n = self.at_rest()
        moments = list(self._moments(cell, *errors))
        return self.presses_of(cell, moments, force_n=np.array([force for _, force, *_ in moments]))

    def by_torques(
        self, at: AtPost, robot: Robot, friction_nm: Array, torque_noise_nm: float, rounds: int = 1
    ) -> Presses:
        """The robot presses the cell against the post, in and out; its joints' torques are read.

        friction_nm: (n,) what is not known of each joint's friction. It is against the motion, which turns round.
        rounds: all is done so many times, and the mean of each moment is taken.
        """
        errors, begun_s = (self.draw.normal(0, PLACE_ERROR_M, 2), 1.0), self.time_s
        self.rest_n = self.at_rest()
        done = [list(self._moments(at.cell, *errors)) for _ in range(rounds)]
        moments = [
            (place, force, np.mean([one[k][2] for one in done], axis=0), way, truly)
            for k, (place, force, _, way, truly) in enumerate(done[0])
        ]
        self.mounted_s += self.time_s - begun_s
        return self.with_torques(at, moments, friction_nm, torque_noise_nm, rounds)

    def with_torques(
        self, at: AtPost, moments: list, friction_nm: Array, torque_noise_nm: float, rounds: int = 1
    ) -> Presses:
        """What the joints' torques tell of moments at the post, each the mean of some rounds."""
        true_lever = at.lever_nm_per_n * (1 + self.draw.normal(0, LEVER_ERROR))
        moving = -np.sign(at.lever_nm_per_n)  # into the post: against what the post does to the joint
        direction = np.array([way * moving for _, _, _, way, _ in moments])
        force = np.array([force for _, force, *_ in moments])
        noise = self.draw.normal(0, torque_noise_nm, (rounds, *direction.shape)).mean(axis=0)
        # Of the torque before the touch, the mean of a second, which is taken off.
        free = self.draw.normal(0, torque_noise_nm * np.sqrt(STEP_S / REST_S), (rounds, len(friction_nm))).mean(axis=0)
        torque = true_lever * force[:, None] + direction * friction_nm + noise - free
        lever = np.tile(at.lever_nm_per_n, (len(moments), 1))
        return self.presses_of(at.cell, moments, torque_nm=torque, lever_nm_per_n=lever, direction=direction)

    def _moments(self, cell: int, place_error_m: Array, force_error: float):  # type: ignore[no-untyped-def]
        """(place as planned, force as known, readings (N, 3), 1 in or -1 out) of each moment."""
        for place in PLACES_M:
            for way, levels in ((1, LEVELS_N), (-1, LEVELS_N[-2::-1])):
                for force in levels:
                    truly = self.pressed(cell, force * force_error, place + place_error_m)
                    yield place, force, self.read(truly, STEP_S), way, truly
            for _ in range(6):
                self.read(np.zeros((self.cells, 3)), STEP_S)

    def presses_of(self, cell: int, moments: list, **reference: Array) -> Presses:
        """Moments of a cell with what is known of their forces."""
        beside = self.beside[cell]
        tell = self.rest_n[beside] > 0.05
        carried = []
        for _, _, reading, *_ in moments:
            change = (reading - self.rest_n)[beside][tell]
            carried.append(3 * change.mean() if tell.any() else np.nan)
        return Presses(
            cell=cell,
            neighbours=len(beside),
            rest_n=self.rest_n[cell],
            reading_n=np.array([reading[cell] for _, _, reading, *_ in moments]),
            place_m=np.array([place for place, *_ in moments]),
            carried_n=np.array(carried),
            **reference,
        )


def _read(sensors: SensorModels, time_s: float, force_n: Array) -> Array:
    cells = len(force_n)
    counts: NDArray[np.int32] = sensors.sample(
        time_s,
        np.ascontiguousarray(force_n),
        np.full(cells, np.inf),
        np.ones(cells),
        np.zeros((cells, 3)),
        np.full((cells, 2), 30.0),
    )
    return counts[:, 1:4] * FORCE_STEP_N
