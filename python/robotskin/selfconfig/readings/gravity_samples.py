# SPDX-License-Identifier: Apache-2.0
"""What the cells felt of gravity while the limb rested in several poses: the input of the reconstruction."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray

from robotskin.selfconfig.common.gravity import ACCELERATION_STEP_MPS2


@dataclass(frozen=True, eq=False)
class GravitySamples:
    """Specific force of N cells at rest in K poses, averaged over the samples of each pose.

    mean: (N, K, 3) m/s² in the cell frame, NaN where a cell gave nothing in a pose.
    deviation: (N,) m/s², standard deviation of an axis of `mean`, from the spread of the samples.
    """

    mean: NDArray[np.float64]
    deviation: NDArray[np.float64]

    @classmethod
    def from_raw(cls, acceleration: ArrayLike) -> GravitySamples:
        """Average single samples.

        Args:
            acceleration: (N, K, S, 3) m/s² in the cell frame; S samples a pose (the released software takes 16), NaN
                where one is missing.

        Raises:
            ValueError: not that shape.
        """
        raw = np.asarray(acceleration, dtype=float)
        if raw.ndim != 4 or raw.shape[3] != 3:
            raise ValueError(f"acceleration: shape {raw.shape}: must be (cells, poses, samples, 3)")
        present = np.isfinite(raw).all(axis=3)
        count = present.sum(axis=2)
        filled = np.where(present[..., None], raw, 0.0)
        with np.errstate(invalid="ignore", divide="ignore"):
            mean = np.where(count[..., None] > 0, filled.sum(axis=2) / count[..., None], np.nan)
        spread = np.where(present[..., None], raw - mean[:, :, None], 0.0)
        # One noise level a cell, over all poses; a bumped pose must not inflate it, hence the median of the poses.
        freedom = np.maximum(count - 1, 1)
        variance = (spread**2).sum(axis=(2, 3)) / (3 * freedom)
        variance = np.where(count > 1, variance, np.nan)
        typical = np.array([np.median(row[np.isfinite(row)]) if np.isfinite(row).any() else np.nan for row in variance])
        # A reading that never flickers is still uncertain by its step.
        typical = np.maximum(np.where(np.isfinite(typical), typical, 0.0), ACCELERATION_STEP_MPS2**2 / 12)
        per_pose = np.maximum(np.array([np.median(row[row > 0]) if (row > 0).any() else 1 for row in count]), 1)
        return cls(mean, np.sqrt(typical / per_pose))

    def present(self) -> NDArray[np.bool_]:
        """(N, K) whether the cell gave a reading in the pose."""
        return np.asarray(np.isfinite(self.mean).all(axis=2), dtype=bool)
