# SPDX-License-Identifier: Apache-2.0
"""Pictures of a blinking skin, already read: which cell was seen where, view by view."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from robotskin.selfconfig.localisation.led_camera import Camera, CameraView
from robotskin.selfconfig.localisation.led_sightings import Sighting

Array = NDArray[np.float64]


@dataclass(frozen=True, eq=False)
class LedView:
    """One period of frames: from where, and the B blobs with a name: key (B,), pixel (B, 2), deviation_px (B,)."""

    view: CameraView
    key: NDArray[np.int64]
    pixel: Array
    deviation_px: Array


@dataclass(frozen=True, eq=False)
class LedPictures:
    """What one calibrated camera saw of a skin."""

    camera: Camera
    views: tuple[LedView, ...]

    def of(self, key: NDArray[np.int64]) -> list[Sighting]:
        """The sightings of cells by their keys (n,), in whose order they are numbered; only views that show some."""
        row = {int(one): number for number, one in enumerate(key)}
        found = []
        for view in self.views:
            cell = np.array([row.get(int(one), -1) for one in view.key], dtype=np.int64)
            mine = cell >= 0
            if mine.any():
                found.append(Sighting(view.view, cell[mine], view.pixel[mine], view.deviation_px[mine]))
        return found
