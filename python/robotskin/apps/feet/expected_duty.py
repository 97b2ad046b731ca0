# SPDX-License-Identifier: Apache-2.0
"""What duty the motors ought to have by what the cells say and the file of parameters: computed apart from the app."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from robotskin.apps.feet.exoskeleton import REGIONS, Region
from robotskin.apps.feet.settings import Settings, Vibration
from robotskin.skin import Health, SkinState

Array = NDArray[np.float64]
LATE_S = 0.05
"""After a foot has left the ground, in which samples may still tell of the ground."""


def duty_of_share(share: Array, vibration: Vibration) -> Array:
    """The duty for loads as shares of what a region carries while the wearer stands; NaN where a share is."""
    silent, full = vibration.silent_share, vibration.full_share
    return np.asarray(np.clip((share - silent) / (full - silent), 0.0, 1.0))


class ExpectedDuty:
    """Follows the readings of both soles: zero of each cell, its pressure at standstill, the duty of each region.

    It knows nothing of the app's own zeros, calibration and arithmetic, and so shows what goes wrong in them.

    Args:
        settings: what the app was given.
        stands_s: from when to when the wearer stands still.
        least_felt_n: of a cell at standstill, so that it counts.
    """

    def __init__(self, settings: Settings, stands_s: tuple[float, float], least_felt_n: float) -> None:
        self._settings, self._stands_s, self._least_n = settings, stands_s, least_felt_n
        self._zero = np.zeros(2 * len(REGIONS))
        self._standing: list[Array] = []
        self._last_s = 0.0
        self._loaded_s = np.zeros(2)
        self.pressure_n = np.full(2 * len(REGIONS), np.nan)
        """(14,) above the zero of each cell; NaN where its sample is too old."""

    def read(self, now_s: float, now_ns: int, felt: SkinState, unloaded: NDArray[np.bool_], taring: bool) -> None:
        """Take the next reading; unloaded: (2,) feet that nothing touches."""
        step, self._last_s = now_s - self._last_s, now_s
        self._loaded_s = np.where(unloaded, self._loaded_s, now_s)
        young = np.asarray(felt.stamp_ns) > now_ns - 1e9 * self._settings.vibration.lost_s
        heard = young & (np.asarray(felt.health) == Health.alive.value)
        shown = np.asarray(felt.normal_force, dtype=float).sum(axis=1)
        if taring:
            self._zero[:] = 0.0
            return
        self.pressure_n = np.where(heard, np.maximum(shown - self._zero, 0.0), np.nan)
        follows = heard & np.repeat(now_s - self._loaded_s > LATE_S, len(REGIONS))
        self._zero[follows] += min(step / self._settings.touch.zero_s, 1.0) * (shown - self._zero)[follows]
        if self._stands_s[0] <= now_s <= self._stands_s[1]:
            self._standing.append(self.pressure_n)

    def duty(self, foot: int) -> Array:
        """(3,) of the regions of a foot: by the mean of what its cells feel over what they felt at standstill."""
        cells = slice(foot * len(REGIONS), (foot + 1) * len(REGIONS))
        standing = np.ma.masked_invalid(np.array(self._standing)[:, cells]).mean(axis=0).filled(0.0)
        share = np.ma.masked_invalid(self.pressure_n[cells]) / np.ma.masked_less_equal(standing, self._least_n)
        regions = np.ma.stack([share[region == REGIONS].mean() for region in Region])
        return duty_of_share(regions.filled(0.0), self._settings.vibration)
