# SPDX-License-Identifier: Apache-2.0
"""Sets of cells as integers, bit `c` for cell `c`: to grow a tree over them is a few operations a cell."""

from __future__ import annotations

from collections.abc import Iterator


def neighbour_sets(near: list[list[int]]) -> list[int]:
    """The neighbours of each cell as a set."""
    return [set_of(row) for row in near]


def set_of(cells: list[int]) -> int:
    """Cells as a set."""
    found = 0
    for cell in cells:
        found |= 1 << cell
    return found


def members(cells: int) -> Iterator[int]:
    """The cells of a set, in order."""
    while cells:
        lowest = cells & -cells
        yield lowest.bit_length() - 1
        cells ^= lowest


def any_of(cells: int) -> int:
    """The set of the first cell alone; empty of an empty set."""
    return cells & -cells


def rings(near: list[int], root: int, allowed: int, deepest: int) -> list[int]:
    """The allowed cells at one hop, the root itself, at two, and so on: breadth first through allowed cells alone.

    Args:
        near: neighbours of each cell, as sets.
        root: of the tree, which counts as allowed.
        allowed: cells that may be in the tree.
        deepest: hops of the farthest ring.
    """
    ring = seen = 1 << root
    found = [ring]
    while len(found) < deepest:
        beside = 0
        while ring:
            lowest = ring & -ring
            beside |= near[lowest.bit_length() - 1]
            ring ^= lowest
        ring = beside & allowed & ~seen
        if not ring:
            break
        seen |= ring
        found.append(ring)
    return found


def union(sets: list[int]) -> int:
    """All cells of some sets."""
    found = 0
    for cells in sets:
        found |= cells
    return found


def in_several(sets: tuple[int, ...] | list[int]) -> int:
    """The cells that are in more than one of some sets."""
    once = twice = 0
    for cells in sets:
        twice |= once & cells
        once |= cells
    return twice
