# SPDX-License-Identifier: Apache-2.0
"""The floor under a standing robot from above, as a picture of the panel: no foot hides what is drawn on it there."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from robotskin.apps.balance.held import Held

Array = NDArray[np.float64]
Colour = tuple[int, int, int]
CENTRE: Colour = (240, 228, 66)
ZMP: Colour = (230, 120, 40)
CAPTURE: Colour = (86, 180, 233)
SUPPORT: Colour = (0, 200, 140)
FLOOR_FORCE: Colour = (64, 150, 220)
WIDTH_PX, HEIGHT_PX, PX_PER_M = 250, 172, 680.0


def floor_map(held: Held) -> str:
    """SVG: ahead of the robot is up, its left is left; the support polygon's middle is the picture's."""
    middle = (held.corners.min(axis=0) + held.corners.max(axis=0)) / 2

    def at(place: Array) -> str:
        ahead, left = place - middle
        return f"{WIDTH_PX / 2 - PX_PER_M * left:.1f},{HEIGHT_PX / 2 - PX_PER_M * ahead:.1f}"

    def spot(place: Array, colour: Colour, radius: float, name: str) -> str:
        x, y = at(place).split(",")
        return f'<circle data-spot="{name}" cx="{x}" cy="{y}" r="{radius}" fill="rgb{colour}"/>'

    corners = " ".join(at(corner) for corner in held.corners)
    drawn = [f'<polygon points="{corners}" fill="rgb{SUPPORT}" fill-opacity=".12" stroke="rgb{SUPPORT}"/>']
    if held.force is not None:
        share = held.force[:, 2].clip(min=0.0) / max(float(held.force[:, 2].sum()), 1.0)
        # The area of the spot is the foot's share of the load.
        drawn += [
            spot(place, FLOOR_FORCE, 11 * np.sqrt(one), foot)
            for place, one, foot in zip(held.pressed, share, ("left", "right"), strict=True)
        ]
    drawn.append(spot(held.centre[:2], CENTRE, 6.5, "centre"))
    if held.zmp is not None:
        drawn.append(spot(held.zmp, ZMP, 4.5, "zmp"))
    drawn.append(spot(held.capture, CAPTURE, 2.8, "capture"))
    return (
        f'<svg width="{WIDTH_PX}" height="{HEIGHT_PX}" viewBox="0 0 {WIDTH_PX} {HEIGHT_PX}" role="img" '
        f'aria-label="the soles from above, ahead is up" style="display:block;max-width:100%">{"".join(drawn)}</svg>'
    )
