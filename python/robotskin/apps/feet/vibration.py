# SPDX-License-Identifier: Apache-2.0
"""From the load under a foot to the duty of three motors."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from robotskin.apps.feet.exoskeleton import REGIONS, Region
from robotskin.apps.feet.motors import STEPS
from robotskin.apps.feet.settings import Vibration
from robotskin.errors import InputError

Array = NDArray[np.float64]


class Calibration:
    """What each cell feels while the wearer stands still, so that felt force becomes load.

    How much of the load the insole carries beside a cell differs from cell to cell and is not known beforehand. While
    the wearer stands on both feet each region of both soles carries the same share of the weight.

    Args:
        weight_n: of wearer and exoskeleton.
        felt_n: (14,) newton, mean of each cell while standing; NaN for one that was not heard.

    Raises:
        InputError: a region without any cell that felt the standing weight.
    """

    LEAST_FELT_N = 0.3

    def __init__(self, weight_n: float, felt_n: Array) -> None:
        self.region_n = weight_n / (2 * len(Region))
        """What a region carries while the wearer stands."""
        usable = np.isfinite(felt_n) & (np.nan_to_num(felt_n) > self.LEAST_FELT_N)
        self.load_per_newton = np.where(usable, self.region_n / np.where(usable, felt_n, 1.0), np.nan)
        """(14,) newton of the region for a newton of the cell; NaN: the cell is not used."""
        for foot in range(2):
            for region in Region:
                if not usable[7 * foot : 7 * foot + 7][region == REGIONS].any():
                    raise InputError(
                        f"calibration: no cell of the {region.name.lower()} of the {('left', 'right')[foot]} sole felt "
                        f"{self.LEAST_FELT_N:g} N; let the wearer stand on both feet"
                    )

    def loads(self, foot: int, force_n: Array, heard: NDArray[np.bool_]) -> Array:
        """(3,) newton on each region of a foot, from its cells (7,); NaN where none of its cells is heard."""
        scale = self.load_per_newton[7 * foot : 7 * foot + 7]
        each = np.where(heard, scale * force_n, np.nan)
        result = np.full(len(Region), np.nan)
        for region in Region:
            known = each[(region == REGIONS) & np.isfinite(each)]
            if len(known):
                result[region] = known.mean()
        return result


def duty_of(loads_n: Array, calibration: Calibration, settings: Vibration) -> Array:
    """(3,) duty for the loads (3,) of the regions: proportional between two loads, 0 where a load is not known."""
    silent, full = settings.silent_share * calibration.region_n, settings.full_share * calibration.region_n
    duty = np.clip((np.nan_to_num(loads_n, nan=0.0) - silent) / (full - silent), 0.0, 1.0)
    return np.asarray(np.round(duty * STEPS) / STEPS)
