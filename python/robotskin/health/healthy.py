# SPDX-License-Identifier: Apache-2.0
"""What healthy cells are known to do, as data sheets and published readings have it; far beyond lies an illness."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from robotskin import firmware
from robotskin.health.kinds import CHANNELS
from robotskin.skin import STANDARD_GRAVITY_MPS2

PROXIMITY, FORCES, ACCELERATIONS, BOARD, SURFACE = 0, slice(1, 4), slice(4, 7), 7, 8
"""Where the channels of each sensor stand."""

STEP: NDArray[np.float64] = np.array(
    [step * (STANDARD_GRAVITY_MPS2 if unit == "g" else 1.0) for _, _, _, step, unit in firmware.CHANNELS]
)
"""(9) one count of each channel in SI units."""


@dataclass(frozen=True)
class Healthy:
    """Bounds of healthy sensors, and from where on one is called ill.

    Noise is told as standard deviations, in counts for proximity and force. `untouched_share`: proximity below it says
    that nothing touches the cell; below `free_share` nothing touches a cell beside it. `leant_n`: by which the force
    of a cell rises, at least, when something comes to rest on it; `leaves_s`: for how long it feels less than half of
    that before the thing is gone. What is seen above `comes_share` may come to the very face of a cell, and stay there
    untouched for `stays_s`. `rest_force_n`: what a force sensor may show with nothing there: pre-load and offset.
    `carried_share`: of a cell's force, at most, that the soft layer carries to one beside it. `creep`: share of a load
    by which a force sensor may be off a while after it, with its time constant.
    """

    proximity_noise_counts: float = 1.2
    force_noise_counts: float = 0.5
    acceleration_noise_g: float = 0.010
    thermometer_noise_k: float = 0.02
    noise_ratio: float = 2.5
    silent_s: float = 1.0
    stuck_samples: int = 100
    stuck_s: float = 5.0
    zero_samples: int = 2500
    zero_s: float = 35.0
    temperature_stuck_s: float = 15.0
    end_s: float = 5.0
    untouched_share: float = 0.12
    free_share: float = 0.03
    touched_n: float = 0.5
    leant_n: float = 0.1
    leaves_s: float = 2.0
    comes_share: float = 0.5
    stays_s: float = 60.0
    carried_share: float = 0.2
    rest_force_n: float = 0.6
    drift_n_per_min: float = 0.022
    creep: float = 0.06
    creep_time_s: float = 40.0
    hot_k: float = 12.0
    hot_c: float = 70.0

    @property
    def noise(self) -> NDArray[np.float64]:
        """(9) SI units, of each channel; 0 where only other cells tell."""
        noise = np.zeros(len(CHANNELS))
        noise[PROXIMITY] = self.proximity_noise_counts * STEP[PROXIMITY]
        noise[FORCES] = self.force_noise_counts * STEP[FORCES]
        noise[ACCELERATIONS] = self.acceleration_noise_g * STANDARD_GRAVITY_MPS2
        return noise
