# SPDX-License-Identifier: Apache-2.0
"""The way of the carriage: up and down smoothly, and shaken."""

from __future__ import annotations

import numpy as np


class Carriage:
    """A reference of position and velocity. It begins at 0 and rests."""

    def __init__(self) -> None:
        self.position_m = 0.0
        self._from_m = self._to_m = 0.0
        self._since_s = self._lasts_s = 0.0
        self._amplitude_m = self._hertz = self._shaken_s = self._shakes_s = 0.0

    def go(self, position_m: float, speed_m_s: float = 0.1) -> None:
        """Go there, the mean speed given; it starts and ends at rest."""
        self._from_m, self._to_m, self._since_s = self.position_m, position_m, 0.0
        self._lasts_s = abs(position_m - self.position_m) / speed_m_s

    def shake(self, acceleration_m_s2: float, hertz: float, seconds: float) -> None:
        """Swing about where it is, up to this acceleration, after a rise of one swing."""
        self._amplitude_m, self._hertz = acceleration_m_s2 / (2 * np.pi * hertz) ** 2, hertz
        self._shaken_s, self._shakes_s = 0.0, seconds

    @property
    def rests(self) -> bool:
        """Whether it has arrived and is not shaken."""
        return self._since_s >= self._lasts_s and self._shaken_s >= self._shakes_s

    def step(self, period_s: float) -> tuple[float, float]:
        """The reference after a period: metres and m/s."""
        before = self.position_m + self._swing()
        self._since_s = min(self._since_s + period_s, self._lasts_s)
        self._shaken_s = min(self._shaken_s + period_s, self._shakes_s)
        share = 1.0 if self._lasts_s == 0 else self._since_s / self._lasts_s
        self.position_m = self._from_m + (self._to_m - self._from_m) * share * share * (3 - 2 * share)
        now = self.position_m + self._swing()
        return now, (now - before) / period_s

    def _swing(self) -> float:
        if self._shaken_s >= self._shakes_s:
            return 0.0
        rise = min(1.0, self._shaken_s * self._hertz, (self._shakes_s - self._shaken_s) * self._hertz)
        return float(rise * self._amplitude_m * np.sin(2 * np.pi * self._hertz * self._shaken_s))
