# SPDX-License-Identifier: Apache-2.0
"""Patches of one link: grown where cells may lie, and split where they do not hang together."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from robotskin.layout.cell import HEXAGON_SIDE_M, LATTICE_CELL_AREA_M2
from robotskin.layout.growth import Sheet, grow
from robotskin.layout.places import LinkPlaces
from robotskin.layout.relax import overlapping_pairs, tangent_poses

Array = NDArray[np.float64]


def grow_link(places: LinkPlaces, seed: int, tries: int, taken: Array | None = None) -> Sheet:
    """Sheets grown from several first cells, the best one kept, then the rest of the link filled the same way.

    `taken`: (K, 4, 4) cells that the link has already, which are kept clear of.
    """
    taken = np.zeros((0, 4, 4)) if taken is None else taken
    random = np.random.default_rng(seed)
    poses = np.zeros((0, 4, 4))
    edges = np.zeros((0, 4), dtype=np.int64)
    unreachable = ~places.coverable
    if len(taken):
        unreachable |= places.covered(taken)
    for _ in range(40):
        open_places = np.flatnonzero(~unreachable)
        if len(open_places) * places.sample_area < places.rules.least_patch * LATTICE_CELL_AREA_M2 * 0.6:
            break
        standing = np.concatenate([taken, poses])

        def accept(candidates: Array, standing: Array = standing) -> NDArray[np.bool_]:
            good = places.accept(candidates)
            if len(standing) and good.any():
                chosen = np.flatnonzero(good)
                pairs, _ = overlapping_pairs(np.concatenate([standing, candidates[chosen]]), 0.0003)
                mixed = pairs[(pairs.min(axis=1) < len(standing)) & (pairs.max(axis=1) >= len(standing))]
                good[chosen[mixed.max(axis=1) - len(standing)]] = False
            return good

        drawn = random.choice(open_places, 24)
        starts = tangent_poses(places.points[drawn], places.normals[drawn], random.normal(size=(24, 3)))
        usable = np.flatnonzero(accept(starts))
        best: Sheet | None = None
        best_score = -np.inf
        for start in usable[:tries]:
            sheet = grow(places.surface, accept, starts[start])
            if len(sheet.poses) == 0:
                continue
            # Cells in large connected pieces count, loose ones hardly, and a wide gap costs a little.
            _, label = sheet.components()
            sizes = np.bincount(label)
            score = float(np.sum(sizes**1.2)) - sheet.gaps().sum() / HEXAGON_SIDE_M
            if score > best_score:
                best, best_score = sheet, score
        if best is None:
            # Nothing fits around these samples; a fifth of the open places is given up each time.
            unreachable[random.choice(open_places, max(1, len(open_places) // 5), replace=False)] = True
            continue
        edges = np.concatenate([edges, best.edges + np.array([len(poses), 0, len(poses), 0])])
        poses = np.concatenate([poses, best.poses])
        unreachable |= places.covered(best.poses)
        for pose in best.poses[:1]:
            unreachable |= np.sum((places.points - pose[:3, 3]) ** 2, axis=1) < HEXAGON_SIDE_M**2
    sheet = Sheet(poses, edges)
    if len(poses):
        sheet = sheet.keep(places.accept(poses, exact=True))
    if len(sheet.poses):
        _, label = sheet.components()
        sheet = sheet.keep(np.bincount(label)[label] >= places.rules.least_patch)
    return sheet


def split(sheet: Sheet) -> list[Sheet]:
    """The connected patches of a sheet."""
    if len(sheet.poses) == 0:
        return []
    count, label = sheet.components()
    return [sheet.keep(label == number) for number in range(count)]
