# SPDX-License-Identifier: Apache-2.0
"""What the cells felt while one joint swung."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from robotskin.selfconfig.babbling.joint_sine import JointSine

Array = NDArray[np.float64]


@dataclass(frozen=True, eq=False)
class MotionRecording:
    """One swing of one joint as N cells felt it at M instants.

    swing: what was commanded; time_s: (M,) since its start; acceleration: (N, M, 3) m/s² specific force, cell frame.
    posture: (M, n) rad or m of all joints as measured then, where more than the swung joint moves, such as the base of
        a robot on its feet; None where all others stay.
    """

    swing: JointSine
    time_s: Array
    acceleration: Array
    posture: Array | None = None

    @cached_property
    def present(self) -> NDArray[np.bool_]:
        """(N, M) whether a reading came."""
        # Axis by axis: a reduction over three numbers takes several times longer.
        finite = np.isfinite(self.acceleration)
        return np.asarray(finite[..., 0] & finite[..., 1] & finite[..., 2], dtype=bool)
