# SPDX-License-Identifier: Apache-2.0
"""The zeros of force sensors while the robot works: followed where nothing is near a cell."""

from __future__ import annotations

import dataclasses
from datetime import UTC, datetime

import numpy as np
from numpy.typing import NDArray

from robotskin.calibration.calibration import Calibration
from robotskin.calibration.force_sensors import OFFSET, Array

WALK_N = 0.02
"""How far a zero moves in a minute, standard deviation."""
READING_N = 0.02
FAR_N = 0.3
"""A reading that is farther from the zero is a touch that nothing saw come."""


class ZeroWatch:
    """Follows the offset of each sensor of a calibration, once a second or so.

    A sensor whose offset is below zero shows nothing untouched: its zero cannot be followed, and only grows less sure.
    """

    def __init__(self, calibration: Calibration) -> None:
        self.calibration = calibration
        self.offset_n = calibration.parameters[:, OFFSET].copy()
        """(N, 3)."""
        diagonal = np.diagonal(calibration.covariance, axis1=1, axis2=2)[:, OFFSET]
        self.variance = np.where(calibration.calibrated[:, None], diagonal, READING_N**2)
        """(N, 3) newton squared."""

    def look(self, reading_n: Array, untouched: NDArray[np.bool_], seconds: float) -> None:
        """Take in readings (N, 3) that are `seconds` after the last; untouched: (N,) cells with nothing near."""
        self.variance += WALK_N**2 * seconds / 60
        told = untouched[:, None] & (reading_n > 0) & (np.abs(reading_n - self.offset_n) < FAR_N)
        weight = np.where(told, self.variance / (self.variance + READING_N**2), 0.0)
        self.offset_n += weight * (reading_n - self.offset_n)
        self.variance *= 1 - weight

    @property
    def drift_n(self) -> Array:
        """(N, 3) how far each zero has moved since the calibration."""
        return self.offset_n - self.calibration.parameters[:, OFFSET]

    def calibrated_anew(self) -> Calibration:
        """The calibration with the zeros of now. What offsets share with gains in the covariance shrinks with them."""
        old = self.calibration
        parameters, covariance = old.parameters.copy(), old.covariance.copy()
        parameters[:, OFFSET] = self.offset_n
        before = np.sqrt(np.diagonal(covariance, axis1=1, axis2=2)[:, OFFSET])
        ratio = np.ones(old.parameters.shape)
        ratio[:, OFFSET] = np.sqrt(self.variance) / np.where(before > 0, before, np.inf)
        covariance *= ratio[:, :, None] * ratio[:, None, :]
        date = datetime.now(UTC).isoformat(timespec="seconds")
        return dataclasses.replace(
            old, parameters=parameters, covariance=covariance, date=date, method=f"{old.method}; zeros followed at work"
        )
