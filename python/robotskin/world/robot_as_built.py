# SPDX-License-Identifier: Apache-2.0
"""The robot as it was built, which is never quite the one that its model describes."""

from __future__ import annotations

import mujoco
import numpy as np
from numpy.typing import NDArray
from scipy.spatial.transform import Rotation

from robotskin.simulator import Imperfections

PURPOSE = 0x0B17
"""Keeps these draws apart from others of the same seed."""


def build_differently(spec: mujoco.MjSpec, imperfections: Imperfections, seed: int) -> None:
    """Shift and turn every joint in its parent link, and make every link heavier or lighter.

    A link keeps its own frame, which is that of the joint that carries it: cells sit where the layout says in the frame
    of the link as built.

    Args:
        spec: of the robot alone, changed in place.
        imperfections: `link_shift_mm`, `link_turn_deg`, `link_mass`.
        seed: of the run; every joint and link draws its own.
    """
    random = np.random.default_rng([PURPOSE, seed])
    for body in spec.bodies:
        # All are drawn whatever is switched on, so that switching one off leaves the others as they were.
        shift, turn, sign = direction(random), direction(random), random.choice([-1.0, 1.0])
        if body.joints:
            body.pos = body.pos + 1e-3 * imperfections.link_shift_mm * shift
            built = Rotation.from_quat(body.quat, scalar_first=True) * Rotation.from_rotvec(
                np.radians(imperfections.link_turn_deg) * turn
            )
            body.quat = built.as_quat(scalar_first=True)
        factor = 1.0 + sign * imperfections.link_mass
        body.mass = body.mass * factor
        body.inertia = body.inertia * factor
        body.fullinertia = body.fullinertia * factor


def direction(random: np.random.Generator) -> NDArray[np.float64]:
    """(3,) a unit vector, drawn evenly."""
    vector = random.standard_normal(3)
    return vector / np.linalg.norm(vector)
