# SPDX-License-Identifier: Apache-2.0
"""Patches of all links trimmed to exactly the number of cells asked for, while each link keeps what it needs."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from types import MappingProxyType

import numpy as np

from robotskin.layout.growth import Sheet
from robotskin.layout.wiring import hop_counts

SMALL_PATCH = 8
"""Patches with fewer cells are left out while larger ones suffice, since each needs a cable of its own; but not the
last one of a link: a small link keeps its cells."""

NO_NEEDS: Mapping[str, int] = MappingProxyType({})


def trimmed(
    patches: Sequence[tuple[str, Sheet]],
    cells: int,
    links: Sequence[str],
    least_patch: int,
    *,
    needs: Mapping[str, int] = NO_NEEDS,
    keep_small: bool = False,
) -> list[tuple[str, Sheet]]:
    """As many cells as asked for, each patch with its link, in the order of the links.

    needs: by link, cells that it keeps if it has so many; together no more than `cells`. keep_small: whether small
    patches stay although larger ones suffice.
    """
    kept = sorted(patches, key=lambda entry: -len(entry[1].poses))
    if not keep_small:
        kept = without_small(kept, cells, needs)
    kept.sort(key=lambda entry: (links.index(entry[0]), -len(entry[1].poses)))
    smaller = trim_to([patch for _, patch in kept], cells, least_patch, shares(kept, needs))
    return [(link, patch) for (link, _), patch in zip(kept, smaller, strict=True) if len(patch.poses)]


def shares(patches: Sequence[tuple[str, Sheet]], needs: Mapping[str, int]) -> list[int]:
    """What each patch keeps of its link's need: the first patches of a link give what they have."""
    left = dict(needs)
    result = []
    for link, patch in patches:
        result.append(min(len(patch.poses), left.get(link, 0)))
        left[link] = left.get(link, 0) - result[-1]
    return result


def trim_to(patches: list[Sheet], cells: int, least_patch: int, least: Sequence[int] | None = None) -> list[Sheet]:
    """Take cells away until exactly as many are left as asked for.

    Every patch gives up its share, from its rim, farthest from its middle first, so that what is left is compact and
    connected. least: cells that a patch keeps although it then is the larger for it; together no more than `cells`.
    """
    sizes = np.array([len(patch.poses) for patch in patches])
    kept = np.zeros(len(sizes), dtype=int) if least is None else np.asarray(least, dtype=int)
    quota = np.floor(sizes * cells / sizes.sum()).astype(int)
    quota = np.maximum(quota, np.maximum(kept, np.minimum(sizes, least_patch)))
    while quota.sum() != cells:
        if quota.sum() < cells:
            quota[np.argmax((sizes - quota) / sizes)] += 1
        else:
            # A patch falls below the least one only when all are that small, and below what it keeps never.
            spare = quota / sizes - 9 * (quota <= least_patch) - 99 * (quota <= kept)
            quota[np.argmax(spare)] -= 1
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


def without_small(
    patches: Sequence[tuple[str, Sheet]], cells: int, needs: Mapping[str, int] = NO_NEEDS
) -> list[tuple[str, Sheet]]:
    """The patches without the small ones that are not needed, smallest first; every link keeps its largest."""
    size = [len(patch.poses) for _, patch in patches]
    left = list(range(len(patches)))
    for index in sorted(left, key=lambda each: size[each]):
        link = patches[index][0]
        others = [other for other in left if other != index]
        enough = sum(size[other] for other in others) >= cells
        beside = sum(size[other] for other in others if patches[other][0] == link)
        if size[index] < SMALL_PATCH and enough and beside >= max(1, needs.get(link, 0)):
            left = others
    return [patches[index] for index in left]


def worth_a_cable(patches: Sequence[tuple[str, Sheet]], needs: Mapping[str, int] = NO_NEEDS) -> list[tuple[str, Sheet]]:
    """Patches that are not small, of each link that has none of those its largest, and what else a link needs."""
    largest: dict[str, int] = {}
    for link, patch in patches:
        largest[link] = max(largest.get(link, 0), len(patch.poses))
    left = dict(needs)
    worth = []
    for index in sorted(range(len(patches)), key=lambda each: -len(patches[each][1].poses)):
        link, patch = patches[index]
        if len(patch.poses) >= min(SMALL_PATCH, largest[link]) or left.get(link, 0) > 0:
            left[link] = left.get(link, 0) - len(patch.poses)
            worth.append(index)
    return [patches[index] for index in sorted(worth)]
