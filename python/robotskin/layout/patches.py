# SPDX-License-Identifier: Apache-2.0
"""Patches of one link: grown where cells may lie, split where they do not hang together, trimmed to a number."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from robotskin.layout.cell import HEXAGON_SIDE_M, LATTICE_CELL_AREA_M2
from robotskin.layout.growth import Sheet, grow
from robotskin.layout.places import LinkPlaces
from robotskin.layout.relax import overlapping_pairs, tangent_poses
from robotskin.layout.wiring import hop_counts

Array = NDArray[np.float64]

SMALL_PATCH = 8
"""Patches with fewer cells are left out while larger ones suffice, since each needs a cable of its own; but not the
last one of a link: a small link keeps its cells."""


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


def trim_to(patches: list[Sheet], cells: int, least_patch: int) -> list[Sheet]:
    """Take cells away until exactly as many are left as asked for.

    Every patch gives up its share, from its rim, farthest from its middle first, so that what is left is compact and
    connected.
    """
    sizes = np.array([len(patch.poses) for patch in patches])
    quota = np.floor(sizes * cells / sizes.sum()).astype(int)
    quota = np.maximum(quota, np.minimum(sizes, least_patch))
    while quota.sum() != cells:
        change = 1 if quota.sum() < cells else -1
        room = (sizes - quota) / sizes if change > 0 else quota / sizes - 9 * (quota <= least_patch)
        quota[np.argmax(room)] += change
    result = []
    for patch, wanted in zip(patches, quota, strict=True):
        hops = hop_counts(len(patch.poses), patch.edges)
        middle = int(np.argmin(hops.sum(axis=1)))
        distance = np.linalg.norm(patch.poses[:, :3, 3] - patch.poses[middle, :3, 3], axis=1)
        order = np.lexsort((distance, hops[middle]))
        keep = np.zeros(len(patch.poses), dtype=bool)
        keep[order[:wanted]] = True
        result.append(patch.keep(keep))
    return result


def without_small(patches: list[Sheet], links: list[str], cells: int) -> list[Sheet]:
    """The patches without the small ones that are not needed, smallest first; every link keeps its largest."""
    left = list(range(len(patches)))
    for index in sorted(left, key=lambda each: len(patches[each].poses)):
        others = [other for other in left if other != index]
        enough = sum(len(patches[other].poses) for other in others) >= cells
        alone = all(links[other] != links[index] for other in others)
        if len(patches[index].poses) < SMALL_PATCH and enough and not alone:
            left = others
    return [patches[index] for index in left]


def worth_a_cable(patches: list[tuple[str, Sheet]]) -> list[tuple[str, Sheet]]:
    """Patches that are not small, and of each link that has none of those its largest."""
    largest: dict[str, int] = {}
    for link, patch in patches:
        largest[link] = max(largest.get(link, 0), len(patch.poses))
    return [(link, patch) for link, patch in patches if len(patch.poses) >= min(SMALL_PATCH, largest[link])]


def split(sheet: Sheet) -> list[Sheet]:
    """The connected patches of a sheet."""
    if len(sheet.poses) == 0:
        return []
    count, label = sheet.components()
    return [sheet.keep(label == number) for number in range(count)]
