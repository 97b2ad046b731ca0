# SPDX-License-Identifier: Apache-2.0
"""What the network is measured against: trees of the first arrival, and the largest skin that such trees carry."""

from __future__ import annotations

import heapq
from random import Random
from statistics import median

import numpy as np

from robotskin import firmware
from robotskin.layout.cell_network import CellNetwork
from robotskin.layout.network_limits import bottleneck
from robotskin.layout.network_shapes import DOWN, UP, assemble, lattice
from robotskin_lab.bench.network_set import draw_cells

AROUND = 11
"""Cells around the growing cylinder."""
SPREAD = 0.2
"""Of a flood's delay from hop to hop."""
PLACEMENTS = ("one end even", "one end drawn", "both ends drawn")


def first_arrival_loads(network: CellNetwork, seed: int) -> list[int]:
    """(K,) cells of each cable if every cell joins the tree whose flood reaches it first; each hop takes 1 to 1.2."""
    random = Random(f"flood {seed}")
    near = [[int(other) for other in row if other >= 0] for row in network.neighbours[:, :, 0]]
    owner = [-1] * len(network)
    arrivals = [(random.random() * SPREAD, cable, int(root)) for cable, root in enumerate(network.roots)]
    heapq.heapify(arrivals)
    while arrivals:
        when, cable, cell = heapq.heappop(arrivals)
        if owner[cell] >= 0:
            continue
        owner[cell] = cable
        for other in near[cell]:
            if owner[other] < 0:
                heapq.heappush(arrivals, (when + 1 + SPREAD * random.random(), cable, other))
    return np.bincount([tree for tree in owner if tree >= 0], minlength=len(network.roots)).tolist()


def first_arrival_fullest(network: CellNetwork, seed: int, floods: int = 9) -> float:
    """Cells of the fullest cable, the median of several floods."""
    return median(max(first_arrival_loads(network, floods * seed + flood)) for flood in range(floods))


def cylinder(rows: int, ports: int, placement: str, seed: int) -> CellNetwork:
    """The growing cylinder at `rows` rows of 11; the cables' places around it are those of the seed at every size.

    Args:
        rows: of cells along the cylinder.
        ports: cables.
        placement: one of `PLACEMENTS`.
        seed: draws the places.
    """
    random = Random(f"growing {placement} {ports} {seed}")
    links, position = lattice(AROUND, AROUND * rows, wrapped=True)
    network = assemble("growing cylinder", AROUND * rows, links, position)
    if placement == "one end even":
        first = int(random.random() * AROUND)
        places = [(first + AROUND * cable // ports) % AROUND for cable in range(ports)]
    else:
        ends = AROUND if placement == "one end drawn" else 2 * AROUND
        places = draw_cells(random, np.arange(ends), ports)
    far = AROUND * (rows - 1)
    ends_at = [(place, UP) if place < AROUND else (far + place - AROUND, DOWN) for place in places]
    return network.with_cables(ends_at)


def naive_rows(ports: int, placement: str, seed: int) -> int:
    """Rows of the longest cylinder, grown row by row, whose fullest first-arrival tree has no more than 66 cells."""
    rows = 2
    while first_arrival_fullest(cylinder(rows + 1, ports, placement, seed), seed) <= firmware.CELLS_PER_PORT:
        rows += 1
    return rows


def most_rows(ports: int, placement: str, seed: int) -> int:
    """Rows of the longest cylinder that any routing can serve."""
    rows = ports * firmware.CELLS_PER_PORT // AROUND + 1
    while bottleneck(cylinder(rows, ports, placement, seed)).cells_per_line > firmware.CELLS_PER_PORT:
        rows -= 1
    return rows
