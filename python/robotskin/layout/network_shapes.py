# SPDX-License-Identifier: Apache-2.0
"""Cells clipped together in regular shapes: sheets, cylinders, compact patches, rings of patches."""

from __future__ import annotations

from collections.abc import Sequence
from functools import cache
from random import Random

import numpy as np
from numpy.typing import NDArray
from scipy.sparse import csr_matrix
from scipy.sparse.csgraph import connected_components

from robotskin.layout.cell import LATTICE_PITCH_M
from robotskin.layout.cell_network import CellNetwork

EAST, DOWN, UP, WEST = 1, 2, 3, 4
"""Ports that face each other in the flat lattice: 1 and 4, 2 and 3."""
ROW_HEIGHT = np.sqrt(3) / 2
"""Of a row of hexagons, in lattice pitches."""

Links = list[tuple[int, int, int, int]]
"""cell, port, cell, port."""


def draw(random: Random, count: int) -> int:
    """An index below `count`. Only `Random.random` is promised to be the same in every version of Python."""
    return int(random.random() * count)


def assemble(name: str, count: int, links: Links, position: NDArray, patch: NDArray | None = None) -> CellNetwork:
    """Cells 0 to count - 1 with ids from 1, without cables. position: (N, 2) lattice pitches, laid flat."""
    neighbours = np.full((count, 4, 2), (-1, 0), dtype=np.int32)
    for a, port_a, b, port_b in links:
        assert neighbours[a, port_a - 1, 0] < 0, f"cell {a} port {port_a} is taken"
        assert neighbours[b, port_b - 1, 0] < 0, f"cell {b} port {port_b} is taken"
        neighbours[a, port_a - 1] = (b, port_b)
        neighbours[b, port_b - 1] = (a, port_a)
    patches = np.zeros(count, dtype=np.int32) if patch is None else np.asarray(patch, dtype=np.int32)
    ids = np.arange(1, count + 1, dtype=np.uint16)
    link, group = np.zeros(count, dtype=np.int32), np.ones(count, dtype=np.uint16)
    position_m = np.column_stack([position, np.zeros(count)]) * LATTICE_PITCH_M
    return CellNetwork(name, neighbours, (), ids, group, patches, link, position_m)


def labels(count: int, links: Sequence[tuple[int, int, int, int]]) -> NDArray[np.int32]:
    """(N,) connected part of each cell."""
    ends = np.array(links, dtype=np.int64).reshape(-1, 4)
    graph = csr_matrix((np.ones(len(ends)), (ends[:, 0], ends[:, 2])), shape=(count, count))
    return connected_components(graph, directed=False)[1]


def lattice(columns: int, count: int, sheared: bool = False, wrapped: bool = False) -> tuple[Links, NDArray]:
    """Links and positions of `count` hexagonal cells in rows of `columns`, the last row as far as they reach.

    sheared: every cell's lower link leaves by the same flat side, so that columns lean; otherwise columns stay
    straight, as cells of every second row are turned. wrapped: rows are rings, the sheet a cylinder.
    """
    links: Links = []
    for cell in range(count):
        row, column = divmod(cell, columns)
        if column + 1 < columns:
            if cell + 1 < count:
                links.append((cell, EAST, cell + 1, WEST))
        elif wrapped:
            links.append((cell, EAST, row * columns, WEST))
        below = column + (row % 2 if sheared else 0)
        if wrapped:
            below %= columns
        other = (row + 1) * columns + below
        if below < columns and other < count:
            links.append((cell, DOWN, other, UP))
    rows, places = np.divmod(np.arange(count), columns)
    return links, np.column_stack([places + 0.5 * (rows % 2), -rows * ROW_HEIGHT])


def without_links(count: int, links: Links, share: float, random: Random) -> Links:
    """Links are taken away in a drawn order until `share` of them is gone, but none that holds the skin together."""
    order = [(random.random(), index) for index in range(len(links))]
    order.sort()
    gone = [links[index] for _, index in order[: round(share * len(links))]]
    kept = [links[index] for _, index in order[len(gone) :]]
    # Deleting in order what leaves the graph connected keeps what Kruskal's algorithm would add in the reverse order.
    label = labels(count, kept)
    for link in reversed(gone):
        a, b = label[link[0]], label[link[2]]
        if a != b:
            label[label == a] = b
            kept.append(link)
    return sorted(kept)


@cache
def blob(count: int) -> tuple[tuple[tuple[int, int], ...], tuple[tuple[int, int, int, int], ...]]:
    """A compact patch grown ring by ring: axial places of its cells and their links."""
    reach = range(-int(np.sqrt(count)) - 2, int(np.sqrt(count)) + 3)
    places = sorted(
        ((q, r) for q in reach for r in reach),
        key=lambda p: (max(abs(p[0]), abs(p[1]), abs(p[0] + p[1])), p[0] ** 2 + p[1] ** 2 + p[0] * p[1], p),
    )[:count]
    index = {place: cell for cell, place in enumerate(places)}
    links = [
        (cell, port, index[q + dq, r + dr], back)
        for (q, r), cell in index.items()
        for dq, dr, port, back in ((1, 0, EAST, WEST), (0, 1, DOWN, UP))
        if (q + dq, r + dr) in index
    ]
    return tuple(places), tuple(links)


def shares(random: Random, patches: int, cells: int, least: int) -> list[int]:
    """Sizes of patches that add up to `cells`; largest and smallest differ by about 3.5 times."""
    weights = [12 + 30 * random.random() for _ in range(patches)]
    sizes = [max(least, round(weight * cells / sum(weights))) for weight in weights]
    while sum(sizes) != cells:
        which = draw(random, patches)
        change = 1 if sum(sizes) < cells else -1
        if sizes[which] + change >= least:
            sizes[which] += change
    return sizes


def rings_of_patches(name: str, sizes: Sequence[int], per_ring: int, bridges: int, random: Random) -> CellNetwork:
    """Compact patches in rings of `per_ring`, each joined to the next by `bridges` cables between drawn free ports."""
    links: Links = []
    positions: list[tuple[float, float]] = []
    patch: list[int] = []
    start = 0
    members: list[list[int]] = []
    for number, size in enumerate(sizes):
        places, inside = blob(size)
        links += [(a + start, port_a, b + start, port_b) for a, port_a, b, port_b in inside]
        ring, seat = divmod(number, per_ring)
        angle = 2 * np.pi * seat / per_ring
        x, y = 2.25 * per_ring * np.cos(angle) + 6.5 * per_ring * ring, 2.25 * per_ring * np.sin(angle)
        positions += [(x + q + 0.5 * r, y - r * ROW_HEIGHT) for q, r in places]
        patch += [number] * size
        members.append(list(range(start, start + size)))
        start += size
    free = [[1, 2, 3, 4] for _ in range(start)]
    for a, port_a, b, port_b in links:
        free[a].remove(port_a)
        free[b].remove(port_b)
    rings = [list(range(first, min(first + per_ring, len(sizes)))) for first in range(0, len(sizes), per_ring)]
    if len(rings) > 1 and len(rings[-1]) < 3:
        last = rings.pop()
        rings[-1] += last

    def plug(which: int) -> tuple[int, int]:
        open_cells = [cell for cell in members[which] if free[cell]]
        cell = open_cells[draw(random, len(open_cells))]
        return cell, free[cell].pop(0)

    for circle in rings:
        for here, there in zip(circle, circle[1:] + circle[:1], strict=True):
            for _ in range(bridges):
                links.append((*plug(here), *plug(there)))
    return assemble(name, start, links, np.array(positions), np.array(patch))
