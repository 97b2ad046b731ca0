# SPDX-License-Identifier: Apache-2.0
"""What gravity samples can tell at all, before anything is computed from them."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from robotskin.errors import RobotskinError
from robotskin.selfconfig.common.gravity import GRAVITY_MPS2
from robotskin.selfconfig.readings.gravity_samples import GravitySamples


class UnobservableRotationError(RobotskinError):
    """Gravity samples that leave the rotation of every cell about one axis open.

    axis_in_cell: (3,) unit vector in the frame of the cell `cell`; uncertainty_rad: standard deviation of the rotation
    about it that the data would leave.
    """

    def __init__(self, why: str, cell: int, axis_in_cell: NDArray[np.float64], uncertainty_rad: float) -> None:
        self.cell, self.axis_in_cell, self.uncertainty_rad = cell, axis_in_cell, uncertainty_rad
        axis = ", ".join(f"{value:+.2f}" for value in axis_in_cell)
        super().__init__(
            f"{why}: the rotation of the cells about the axis ({axis}) in the frame of cell {cell} cannot be observed; "
            "add a pose in which gravity points elsewhere"
        )


def require_observable(
    samples: GravitySamples, offset_deviation_mps2: float, largest_deviation_rad: float = 0.2
) -> None:
    """Check that the poses fix all three rotations.

    Rotating a cell about gravity changes nothing it measures. One pose, poses with parallel or opposite gravity, and a
    limb that did not move therefore leave a rotation open. The test asks how uncertain the worst rotation would be for
    the best-placed cell, with its offset unknown.

    Args:
        samples: of all cells.
        offset_deviation_mps2: standard deviation of the accelerometers' unknown offset.
        largest_deviation_rad: what is still called observed; 0.2 rad wants gravity to turn by some 16 degrees.

    Raises:
        UnobservableRotationError: naming the rotation.
    """
    present = samples.present()
    counts = present.sum(axis=1)
    if counts.max(initial=0) == 0:
        raise UnobservableRotationError("no cell gave a gravity sample", 0, np.array([0.0, 0.0, 1.0]), np.inf)
    best, best_deviation, best_axis = -1, np.inf, np.zeros(3)
    for cell in np.flatnonzero(counts == counts.max()):
        gravity = samples.mean[cell, present[cell]]
        length = np.linalg.norm(gravity, axis=1, keepdims=True)
        direction = gravity / np.maximum(length, 1e-9)
        # Information on small rotations: a direction tells nothing about the rotation around itself.
        information = len(direction) * np.eye(3) - direction.T @ direction
        value, vector = np.linalg.eigh(information)
        deviation = (
            np.hypot(offset_deviation_mps2, samples.deviation[cell]) / GRAVITY_MPS2 / np.sqrt(max(value[0], 1e-12))
        )
        if deviation < best_deviation:
            best, best_deviation, best_axis = int(cell), float(deviation), vector[:, 0]
    if best_deviation <= largest_deviation_rad:
        return
    gravity = samples.mean[best, present[best]]
    if len(gravity) == 1:
        why = "only one pose"
    elif np.linalg.norm(gravity - gravity[0], axis=1).max() < 6 * samples.deviation[best]:
        why = f"the limb did not move between the {len(gravity)} poses"
    else:
        why = f"gravity is nearly parallel in all {len(gravity)} poses"
    raise UnobservableRotationError(why, best, best_axis, best_deviation)
