# SPDX-License-Identifier: Apache-2.0
"""The load on a sole and where it presses, from cells that stand beside an insole: in place of a sensor at the ankle.

A stiff, flat sole on foam presses as a plane does: pressure grows evenly over the sole, and is nothing where the foot
would lift off. Each cell bears its own share of it. A calibration finds the shares; then the plane that fits what all
cells feel tells load and moments, also where the foot stands on an edge.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]
_GRID = (48, 48)
"""Points along and across a sole: an edge that bears all is some three of them wide."""
_PASSES = 12
_RIDGE = 3e-4
"""For cells in a row, which leave the slope across it open."""
_FEWEST = 6
"""Sensors that a plane is laid through at least: those that feel most, where fewer feel anything."""
_SLIGHT = 0.03
"""A sensor that feels less than this share of the most says that the foot lifts off there, or nothing."""
_UNSURE = 0.02
"""σ of where a plane presses along an axis, over half the sole, while what feels is spread by 1 along that axis."""


class SolePressure:
    """Pressures under a sole, over the mean that a newton makes; `half_m` (2,): half its length and width."""

    def __init__(self, half_m: tuple[float, float]) -> None:
        self._half = np.array(half_m)
        axes = [np.linspace(-1, 1, 2 * count + 1)[1::2] for count in _GRID]
        self._over_sole = _basis(np.stack(np.meshgrid(*axes, indexing="ij"), axis=-1).reshape(-1, 2))

    def plane(self, centre_m: Array) -> Array:
        """(3,) of the plane whose load is 1 N and presses at `centre_m` (2,) from the sole's middle."""
        plane, basis = np.array([1.0, 0.0, 0.0]), self._over_sole
        target = np.array([1.0, *(centre_m / self._half)])
        for _ in range(_PASSES):
            pressed = np.maximum(basis @ plane, 0.0)
            wrong = target - basis.T @ pressed / len(basis)
            if np.abs(wrong).max() < 1e-3:
                break
            touching = basis[pressed > 0]
            plane += np.linalg.solve(touching.T @ touching / len(basis) + 1e-6 * np.eye(3), wrong)
        return plane

    def at(self, places_m: Array, plane: Array) -> Array:
        """(n,) at `places_m` (n, 2)."""
        return np.asarray(np.maximum(_basis(places_m / self._half) @ plane, 0.0))

    def fitted(self, places_m: Array, pressure: Array, least: Array, open_ended: NDArray[np.bool_]) -> Array:
        """(3,) of the plane nearest to (n,) pressures at `places_m` (n, 2).

        Below `least` (n,) a pressure may be noise. Where `open_ended` (n,) bool, the sensor is at its end: its pressure
        may be more.
        """
        basis = _basis(places_m / self._half)
        plane = np.zeros(3)
        certain = _pressed(pressure, least) & ~open_ended
        if certain.sum() < _FEWEST:
            certain = np.zeros(len(pressure), bool)
            certain[np.argsort(pressure)[-_FEWEST:]] = True
        counted = certain
        for _ in range(_PASSES):
            rows = basis[counted]
            spread = rows.T @ rows + _RIDGE * np.diag([1e-3, 1.0, 1.0])
            plane = np.asarray(np.linalg.solve(spread, rows.T @ pressure[counted]), float)
            # Where the plane is above the floor a sensor that feels nothing counts, too; and one at its end, which
            # feels no less than it says.
            at = basis @ plane
            following = np.where(open_ended, at < pressure, (at > 0) | certain)
            if (following == counted).all():
                break
            counted = following
        return plane

    def unsure(self, places_m: Array, pressure: Array, least: Array) -> Array:
        """(2,) σ of where the plane of `fitted` presses along x and y, over half the sole: large along an axis on which
        few sensors feel, or near ones, and no larger than between the next that feel nothing; 1 at most."""
        places = places_m / self._half
        felt = _pressed(pressure, least)
        rows = _basis(places)[felt]
        variance = np.diag(np.linalg.inv(rows.T @ rows + 1e-9 * np.eye(3)))[1:]
        between = [_between(places[:, axis], felt) for axis in (0, 1)]
        return np.minimum(_UNSURE * np.sqrt(variance), np.array(between) / np.sqrt(12))

    def load(self, plane: Array) -> Array:
        """(3,): newton, and newton metres: the load times x and times y of where it presses."""
        pressed = np.maximum(self._over_sole @ plane, 0.0)
        return np.asarray(self._over_sole.T @ pressed / len(pressed) * np.array([1.0, *self._half]))


class SoleCalibration:
    """What sensors beside an insole say of the load, learnt from poses in which a force plate knew it."""

    def __init__(self, places_m: Array, half_m: tuple[float, float], noise_n: float, range_n: float) -> None:
        """`places_m` (n, 2): sensors, from the sole's middle; `noise_n`: σ of one; `range_n`: where it ends."""
        self.pressure = SolePressure(half_m)
        self._places, self._noise_n, self._range_n = places_m, noise_n, range_n
        self._rim = float(np.max(1 - np.abs(places_m / half_m).max(axis=0)))
        self.share = np.ones(len(places_m))
        """(n,) newton felt by each per newton of load, were it spread evenly."""

    def learn(self, felt: Array, load_n: Array, centre_m: Array) -> None:
        """From poses (p): `felt` (p, n) newton, the load (p) and where it pressed (p, 2)."""
        pairs = zip(load_n, centre_m, strict=True)
        pressed = np.array([load * self.pressure.at(self._places, self.pressure.plane(at)) for load, at in pairs])
        inside = felt < self._range_n
        self.share = (inside * felt * pressed).sum(axis=0) / (inside * pressed * pressed).sum(axis=0)

    def load(self, felt: Array) -> Array:
        """(3,) newton and newton metres, as `SolePressure.load`, of what (n,) sensors feel."""
        plane = self.pressure.fitted(self._places, felt / self.share, self._least, felt >= self._range_n)
        return self.pressure.load(plane)

    def unsure(self, felt: Array) -> Array:
        """(2,) σ of where `load` presses along x and y, over half the sole, from what (n,) sensors feel; 1 beside an
        edge without them."""
        return self.pressure.unsure(self._places, felt / self.share, self._least)

    def doubt(self, felt: Array) -> float:
        """How much of the load on this sole its sensors may miss of it, beside those of other soles: a rim without
        sensors, where few feel anything, and sensors at their end."""
        pressed = _pressed(felt / self.share, self._least)
        ended = np.count_nonzero(felt >= self._range_n) / max(int(np.count_nonzero(pressed)), 1)
        return float(self.unsure(felt).max() * self._rim + ended)

    @property
    def _least(self) -> Array:
        """(n,) of the mean pressure that a newton makes: less may be noise."""
        return 4 * self._noise_n / self.share


def _between(places: Array, felt: NDArray[np.bool_]) -> float:
    """How far it is, along an axis, between the next sensors (n,) or edges beyond all that feel anything."""
    if not felt.any():
        return np.sqrt(12)
    low, high = places[felt].min(), places[felt].max()
    below, above = places[~felt & (places < low)], places[~felt & (places > high)]
    return float(above.min(initial=1.0) - below.max(initial=-1.0))


def _pressed(pressure: Array, least: Array) -> NDArray[np.bool_]:
    return np.asarray(pressure > np.maximum(least, _SLIGHT * pressure.max()))


def _basis(places: Array) -> Array:
    return np.column_stack([np.ones(len(places)), places])
