# SPDX-License-Identifier: Apache-2.0
"""Cells of neighbouring links kept from meeting: over the joint range no prism may touch one of the next link."""

import numpy as np
from numpy.typing import NDArray
from scipy.spatial import cKDTree

from robotskin.layout.cell import HEXAGON_SIDE_M, prism_overlap
from robotskin.layout.growth import Sheet
from robotskin.layout.places import LinkPlaces

Array = NDArray[np.float64]

ROOM_M = 0.001
"""Least distance of two cells on neighbouring links at a sampled joint position."""


def meetings(
    poses: NDArray[np.float64], others: NDArray[np.float64], transforms: NDArray[np.float64]
) -> set[tuple[int, int]]:
    """Pairs of cells that come nearer than the least room in any posture.

    Args:
        poses: (N, 4, 4) link_from_cell of the cells of one link.
        others: (M, 4, 4) likewise of the other link.
        transforms: (Q, 4, 4) other_from_link.
    """
    found: set[tuple[int, int]] = set()
    if len(poses) == 0 or len(others) == 0:
        return found
    tree = cKDTree(others[:, :3, 3])
    for transform in transforms:
        moved = transform @ poses
        near = tree.query_ball_point(moved[:, :3, 3], 2 * HEXAGON_SIDE_M + 2 * ROOM_M)
        pairs = np.array([(a, b) for a, hits in enumerate(near) for b in hits if (a, b) not in found]).reshape(-1, 2)
        if len(pairs):
            depth = prism_overlap(moved[pairs[:, 0]], others[pairs[:, 1]])
            found.update((int(a), int(b)) for a, b in pairs[depth > -ROOM_M])
    return found


def clear_of(sheet: Sheet, places: LinkPlaces, others: dict[str, Sheet]) -> Sheet:
    """The cells of a sheet that meet none of the other links' cells, which stay."""
    met = {
        cell
        for name, _, transforms in places.clearance.neighbours
        if name in others
        for cell, _ in meetings(sheet.poses, others[name].poses, transforms)
    }
    return sheet.keep(~np.isin(np.arange(len(sheet.poses)), sorted(met))) if met else sheet


def separate(sheets: dict[str, Sheet], places: dict[str, LinkPlaces]) -> dict[str, Sheet]:
    """Take out cells until none meets a cell of a neighbouring link; those that meet the most go first."""
    rivals: dict[tuple[str, int], set[tuple[str, int]]] = {}
    done: set[frozenset[str]] = set()
    for link, place in places.items():
        for name, _, transforms in place.clearance.neighbours:
            if name not in sheets or frozenset((link, name)) in done:
                continue
            done.add(frozenset((link, name)))
            for a, b in meetings(sheets[link].poses, sheets[name].poses, transforms):
                rivals.setdefault((link, a), set()).add((name, b))
                rivals.setdefault((name, b), set()).add((link, a))
    removed: dict[str, list[int]] = {link: [] for link in sheets}
    while rivals:
        worst = max(sorted(rivals), key=lambda cell: len(rivals[cell]))
        for other in rivals.pop(worst):
            rivals[other].discard(worst)
            if not rivals[other]:
                del rivals[other]
        removed[worst[0]].append(worst[1])
    return {
        link: sheet.keep(~np.isin(np.arange(len(sheet.poses)), removed[link])) if removed[link] else sheet
        for link, sheet in sheets.items()
    }
