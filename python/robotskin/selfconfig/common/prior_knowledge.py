"""What is known of cells before any measurement."""

from __future__ import annotations

from dataclasses import dataclass

from robotskin.selfconfig.common.gravity import GRAVITY_MPS2


@dataclass(frozen=True)
class PriorKnowledge:
    """Standard deviations of what is known before any measurement.

    offset_mps2, scale: of an accelerometer's axis (offsets to 66 mg and scales to 3 % were seen, both drawn uniformly).
    bend_rad: of the rotation across a hinge about the flat lattice (published patches bend 3 to 9 degrees on average);
        weak enough to decide only where nothing else does, as for a cell whose accelerometer is dead.
    hinge_m: first guess of the hinge tolerance, then estimated; hinge_floor_m: never believed to be smaller.
    """

    offset_mps2: float = 0.038 * GRAVITY_MPS2
    scale: float = 0.0175
    bend_rad: float = 0.35
    hinge_m: float = 3e-4
    hinge_floor_m: float = 5e-6
