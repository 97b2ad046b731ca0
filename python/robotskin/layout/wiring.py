# SPDX-License-Identifier: Apache-2.0
"""Section-unit ports for the patches of a skin: no cable serves more cells than its line can carry."""

import numpy as np
from numpy.typing import NDArray
from scipy.sparse import csr_matrix
from scipy.sparse.csgraph import dijkstra

from robotskin import firmware
from robotskin.layout.cell import CELLS_PER_PORT, PORTS
from robotskin.layout.errors import CoveringError
from robotskin.layout.layout import SectionUnitPort

Integers = NDArray[np.int64]


def hop_counts(count: int, edges: Integers) -> NDArray[np.float64]:
    """(N, N) hops between cells; infinite between patches. edges: (E, 4) cell, port index, cell, port index."""
    graph = csr_matrix((np.ones(len(edges)), (edges[:, 0], edges[:, 2])), shape=(count, count))
    return dijkstra(graph, directed=False, unweighted=True)


def port_loads(hops: NDArray[np.float64], roots: Integers) -> tuple[Integers, Integers]:
    """Which root serves each cell (N,), and how many cells each root could come to serve (K,).

    A cell at equal distance from two roots joins the one whose flood arrives first, so it counts for both.
    """
    nearest = hops[roots].min(axis=0)
    return np.argmin(hops[roots], axis=0), np.sum(hops[roots] == nearest, axis=1)


def choose_roots(hops: NDArray[np.float64], has_free_port: NDArray[np.bool_]) -> Integers:
    """Cells of one connected patch at which cables plug in, as few as keep every load within the limit.

    Lloyd's iteration on the graph: roots spread by farthest point, then each moves to the middle of what it serves.
    """
    count = len(hops)
    allowed = np.flatnonzero(has_free_port)
    fewest = -(-count // CELLS_PER_PORT)
    for number in range(fewest, min(len(allowed), 3 * fewest + 4) + 1):
        roots = [int(allowed[np.argmin(hops[allowed].sum(axis=1))])]
        while len(roots) < number:
            away = hops[roots].min(axis=0)[allowed]
            roots.append(int(allowed[np.argmax(away)]))
        best = np.array(roots)
        for _ in range(12):
            owner, loads = port_loads(hops, best)
            if loads.max() <= CELLS_PER_PORT:
                return best
            moved: list[int] = []
            for root in range(number):
                cost = hops[np.ix_(allowed, np.flatnonzero(owner == root))].sum(axis=1)
                cost[np.isin(allowed, moved)] = np.inf
                moved.append(int(allowed[np.argmin(cost)]))
            if np.array_equal(moved, best):
                break
            best = np.array(moved)
    raise CoveringError(f"no {3 * fewest + 4} cables serve a patch of {count} cells with {CELLS_PER_PORT} cells each")


def wire(
    neighbours: NDArray[np.integer], patch: Integers, ports_per_section_unit: int = firmware.SECTION_UNIT_PORTS_MAX
) -> tuple[NDArray[np.uint16], NDArray[np.uint16], tuple[SectionUnitPort, ...]]:
    """Plug cables into patches and number cells.

    Patches are dealt to section units in order; a patch is never split between two, because its cells share one
    network and therefore one set of ids.

    Args:
        neighbours: (N, 4, 2) as in `Layout`.
        patch: (N,) index of each cell's patch; cells of a patch are connected.
        ports_per_section_unit: cables a section unit takes.

    Returns:
        id (N,), group (N,) from 1, and the section-unit ports.
    """
    count = len(patch)
    cell, port = np.nonzero(neighbours[:, :, 0] >= 0)
    edges = np.stack([cell, port, neighbours[cell, port, 0], neighbours[cell, port, 1] - 1], axis=1).astype(np.int64)
    hops = hop_counts(count, edges)
    free = neighbours[:, :, 0] < 0
    ids = np.zeros(count, dtype=np.uint16)
    groups = np.zeros(count, dtype=np.uint16)
    places: list[SectionUnitPort] = []
    unit, used, next_id = 1, 0, firmware.ID_FIRST
    for number in range(int(patch.max()) + 1):
        members = np.flatnonzero(patch == number)
        rim = np.asarray(free[members].any(axis=1))
        roots = members[choose_roots(hops[np.ix_(members, members)], rim)]
        if len(roots) > ports_per_section_unit:
            raise CoveringError(
                f"patch {number} of {len(members)} cells needs {len(roots)} cables, "
                f"a section unit takes {ports_per_section_unit}"
            )
        if used + len(roots) > ports_per_section_unit:
            unit, used, next_id = unit + 1, 0, firmware.ID_FIRST
        for root in roots:
            used += 1
            places.append(SectionUnitPort(unit, used, int(root), int(np.flatnonzero(free[root])[0]) + 1))
        ids[members] = next_id + np.arange(len(members))
        groups[members] = unit
        next_id += len(members)
    assert free.shape[1] == PORTS
    return ids, groups, tuple(places)
