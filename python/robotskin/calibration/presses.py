# SPDX-License-Identifier: Apache-2.0
"""Presses of one cell: what its sensors showed, and what is known of the force."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from robotskin.calibration.errors import CalibrationError
from robotskin.calibration.force_sensors import Array


@dataclass(frozen=True)
class Presses:
    """K moments of presses of one cell. What is not told is None.

    cell: index in the layout. neighbours: cells beside it that the soft layer reaches.
    rest_n: (3,) what its sensors show untouched. reading_n: (K, 3) what they show. place_m: (K, 2) where it is pressed.
    carried_n: (K,) what a neighbour feels of it, on average; NaN where no neighbour can tell.
    force_n: (K,) by a probe, along the cell's normal.
    torque_nm: (K, n) of the robot, the torque before the touch taken off. lever_nm_per_n: (K, n) torque of a newton on
    the cell. direction: (K, n) sign of the joints' velocities, 0 at rest.
    """

    cell: int
    neighbours: int
    rest_n: Array
    reading_n: Array
    place_m: Array
    carried_n: Array
    force_n: Array | None = None
    torque_nm: Array | None = None
    lever_nm_per_n: Array | None = None
    direction: Array | None = None

    def __post_init__(self) -> None:
        count = len(self.reading_n)
        known = [self.force_n] if self.force_n is not None else [self.torque_nm, self.lever_nm_per_n, self.direction]
        if any(values is None for values in known):
            raise CalibrationError(
                f"presses of cell {self.cell}: neither forces of a probe nor torques with levers and directions"
            )
        for name, values in (("place_m", self.place_m), ("carried_n", self.carried_n), ("the reference", known[0])):
            if values is None or len(values) != count:
                raise CalibrationError(f"presses of cell {self.cell}: {name} is not of {count} moments")
        if not all(np.isfinite(values).all() for values in (self.rest_n, self.reading_n, self.place_m, *known)):
            raise CalibrationError(f"presses of cell {self.cell}: a value is not finite")
