# SPDX-License-Identifier: Apache-2.0
"""A simulated insole with skin cells: what they feel of the force on a sole, and its calibration over a force plate.

The insole is a Winkler foundation under a stiff foot. It carries most of the load beside the cells, and its foam lags.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from robotskin.apps.balance.soles import SoleCalibration, SolePressure

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
CALIBRATION = 400
"""Poses in which the weight is shifted over a force plate."""
LEAST_N, MOST_N = 150.0, 850.0


_RIM = np.array([0.9, 0.83])
"""Over half the sole's length and width: the outer cells' middles, 11 mm from the edge. No cell farther inside feels a
foot that stands on an edge."""


def seven_cells(half_m: tuple[float, float]) -> Array:
    """(7, 2) metres from the sole's middle: three in front, two in the centre, two at the back."""
    places = [(1, -1), (1, 0), (1, 1), (0, -1), (0, 1), (-1, -1), (-1, 1)]
    return np.array(places) * _RIM * half_m


def tiled(half_m: tuple[float, float]) -> Array:
    """(32, 2) metres: the whole sole in cells, eight by four."""
    places = [(along, across) for along in np.linspace(-1, 1, 8) for across in np.linspace(-1, 1, 4)]
    return np.array(places) * _RIM * half_m


class Insole:
    """What the cells of one sole feel of the force on it, and the calibration that makes the load of that.

    Args:
        cells: (n, 2) m from the sole's middle. half_m: half its length and width. generator: of what is drawn.
    """

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
        """(3 n,) newton of each cell's three sensors, under a load that presses at `centre_m` (2,) from the middle."""
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
        self.poses = (np.array(felt), np.array(loads), np.array(centres))
        """Of the calibration: (p, 3 n) N felt, (p,) N of load, (p, 2) m where it pressed."""
        self.calibration.learn(*self.poses)
