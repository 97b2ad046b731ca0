# SPDX-License-Identifier: Apache-2.0
"""What is known of cells before any measurement."""

from __future__ import annotations

import math
from dataclasses import dataclass

from robotskin.selfconfig.common.gravity import GRAVITY_MPS2


@dataclass(frozen=True)
class PriorKnowledge:
    """Standard deviations of what is known before any measurement.

    offset_mps2, scale: of an accelerometer's axis (offsets to 66 mg and scales to 3 % were seen, both drawn uniformly).
    turn_rad: of an accelerometer in its cell about each axis, as parts are placed and soldered, with what its axes take
        from each other unevenly; shear: of what its axes take from each other alike (data sheets allow 1 %).
    link_shift_m, link_turn_rad: how far a joint sits and is turned, along and about each axis, from where the model has
        it (0.5 mm and 0.2 degrees in all, of an arm that was not calibrated).
    bend_rad: of the rotation across a hinge about the flat lattice (published patches bend 3 to 9 degrees on average);
        weak enough to decide only where nothing else does, as for a cell whose accelerometer is dead.
    hinge_m: first guess of the hinge tolerance, then estimated; hinge_floor_m: never believed to be smaller.
    """

    offset_mps2: float = 0.038 * GRAVITY_MPS2
    scale: float = 0.0175
    turn_rad: float = math.radians(0.55)
    shear: float = 0.0041
    link_shift_m: float = 0.5e-3 / math.sqrt(3)
    link_turn_rad: float = math.radians(0.2) / math.sqrt(3)
    bend_rad: float = 0.35
    hinge_m: float = 3e-4
    hinge_floor_m: float = 5e-6
