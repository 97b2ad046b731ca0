# SPDX-License-Identifier: Apache-2.0
"""What is said of a covering below its tables: how areas came out, and which links took too few cells."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np

from robotskin.layout import Layout
from robotskin.layout.places import Area, LinkPlaces, Rules


def area_lines(areas: Sequence[Area], layout: Layout) -> list[str]:
    """A line for each area: how many cells of its link look its way now, those that came later among them."""
    lines = []
    for area in areas:
        normals = layout.link_from_cell[layout.cells_on(area.link), :3, 2]
        looking = int(Rules(facing=area.facing, angle_deg=area.angle_deg).faces(normals).sum())
        along = ",".join(f"{part:g}" for part in area.facing)
        lines.append(
            f"{area.link}: {looking} cells look along {along} within {area.angle_deg:g}°; {area.cells} came first"
        )
    return lines


def short_links(links: Sequence[str], layout: Layout, places: Mapping[str, LinkPlaces], least: int = 0) -> list[str]:
    """A line for each link that got no cell, or fewer than the least, with what stood in the way."""
    count = {link: int(np.sum(layout.link == index)) for index, link in enumerate(layout.links)}
    lines = []
    for link in links:
        worn = count.get(link, 0)
        if worn >= max(1, least):
            continue
        if worn:
            lines.append(
                f"{worn} on {link}, fewer than --least {least}: no more fit; more --tries or --overhang 0.6 may help"
            )
            continue
        room = places[link].coverable.mean()
        if room < 0.3:
            why = "its neighbours come too close over the joint range"
        else:
            why = "it is too narrow or too curved for three cells in a row"
            why += "" if least else ", or its cells went to areas or to larger patches"
        lines.append(f"no cell on {link}: {why}; --overhang 0.6{'' if least else ' or more --cells'} may help")
    return lines
