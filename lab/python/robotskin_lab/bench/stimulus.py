# SPDX-License-Identifier: Apache-2.0
"""People's palms on a skin: where they lie, how steadily they press, how they rub; the same for every run of one seed.

A palm is a ball of 5 cm radius, for a palm that cups a robot's link touches and shades about as many cells. It presses
with 3 to 12 N, the weight of a resting hand and forearm. No hand is steady: isometric force varies by 2 to 4 % of
itself, mostly below 3 Hz (Slifkin and Newell 1999; Enoka et al. 2003), and trembles at 8 to 12 Hz (McAuley and Marsden
2000) with less. Taken here, as our assumption between those: 3 % rms drift and 1 % rms tremor. A rubbing palm strokes
2.5 cm to both sides, 0.7 to 1.3 times a second, which is at most 20 cm/s.
"""

import numpy as np
from numpy.typing import NDArray

from robotskin.world import HandSpec, World

PALM_RADIUS_M = 0.05
FORCE_N = (3.0, 12.0)
DRIFT_RMS, DRIFT_HZ = 0.03, (0.2, 3.0)
TREMOR_RMS, TREMOR_HZ = 0.01, (8.0, 12.0)
STROKE_M, STROKE_HZ = 0.025, (0.7, 1.3)
CYCLE_S = 10.0
ACTIVE_SHARE = 0.02  # of full scale: a cell with more proximity or force is active
_SHADE_M = 0.025  # a ball's surface that near makes a cell active: proximity 0.037, sensors being unlike
_SPACING_M = 2.1 * PALM_RADIUS_M
_CLEARANCE_M = 0.004  # a palm lies that deep in its neighbours' faces at most


def palms(count: int) -> tuple[HandSpec, ...]:
    """As many equal palms."""
    return tuple(HandSpec(radius_m=PALM_RADIUS_M) for _ in range(count))


def places(base_from_cell: NDArray[np.float64], cells_active: int) -> list[int]:
    """Cells on which palms lie so that together they make about so many cells active, few palms first.

    Each next palm takes the place that shades most cells that are still free, where it meets neither another palm nor
    another link. base_from_cell: (N, 4, 4) metres. Fewer active cells if there is no room for more palms.
    """
    position, normal = base_from_cell[:, :3, 3], base_from_cell[:, :3, 2]
    centre = position + PALM_RADIUS_M * normal
    offset = centre[:, None] - position[None]  # from cell to ball
    distance = np.linalg.norm(offset, axis=2)
    shades = (distance < PALM_RADIUS_M + _SHADE_M) & (np.einsum("ijk,jk->ij", offset, normal) > 0.5 * distance)
    free = distance.min(axis=1) > PALM_RADIUS_M - _CLEARANCE_M
    chosen: list[int] = []
    shaded = np.zeros(len(position), dtype=bool)
    while shaded.sum() < cells_active and free.any():
        gain = np.where(free, (shades & ~shaded).sum(axis=1), -1)
        best = int(np.argmax(gain))
        chosen.append(best)
        shaded |= shades[best]
        free &= np.linalg.norm(centre - centre[best], axis=1) >= _SPACING_M
    return chosen


class Palms:
    """Palms that hold or rub; call `drive` before every millisecond of the world.

    Each palm has its place. In a cycle of 10 s it rubs for the share `moving`, stays where its stroke ends and holds
    still until the next cycle; the palms' cycles are spread evenly, so that this share of them rubs at any time.
    """

    def __init__(self, world: World, cells: list[int], seed: int, moving: float) -> None:
        self._hands = list(zip(world.hands, cells, strict=True))
        random = np.random.default_rng(seed)
        count = len(self._hands)
        self.moving = moving
        self._cycle = random.permutation(count) / max(count, 1)
        self._start_s = world.time_s
        self._force_n = random.uniform(*FORCE_N, count)
        self._stroke_hz = random.uniform(*STROKE_HZ, count)
        self._stroke = np.zeros(count)  # cycles
        angle = random.uniform(0, 2 * np.pi, count)
        self._along_m = STROKE_M * np.column_stack([np.cos(angle), np.sin(angle)])
        waves = 4  # of the drift; one more is the tremor
        self._hz = np.column_stack([random.uniform(*DRIFT_HZ, (count, waves)), random.uniform(*TREMOR_HZ, count)])
        self._phase = random.uniform(0, 2 * np.pi, (count, waves + 1))
        self._amplitude = np.sqrt(2) * np.array([DRIFT_RMS / np.sqrt(waves)] * waves + [TREMOR_RMS])

    def force_n(self, time_s: float) -> NDArray[np.float64]:
        """(P,) what each palm presses with at a time."""
        waves = np.sin(2 * np.pi * self._hz * time_s + self._phase)
        return self._force_n * (1 + waves @ self._amplitude)

    def drive(self, time_s: float) -> None:
        """Move every palm on by a millisecond."""
        rubs = (self._cycle + (time_s - self._start_s) / CYCLE_S) % 1 < self.moving
        self._stroke += 0.001 * self._stroke_hz * rubs
        at_m = self._along_m * np.sin(2 * np.pi * self._stroke)[:, None]
        for (hand, cell), force_n, (x_m, y_m) in zip(self._hands, self.force_n(time_s), at_m, strict=True):
            hand.push(cell, float(force_n), (float(x_m), float(y_m)))
