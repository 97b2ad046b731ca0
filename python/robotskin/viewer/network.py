# SPDX-License-Identifier: Apache-2.0
"""Which cable every cell reports through, and the way there: what the colours and lines of the network mean."""

import numpy as np
from scipy.sparse import coo_array
from scipy.sparse.csgraph import connected_components, dijkstra

from robotskin.layout import Layout
from robotskin.layout.cell_network import CellNetwork
from robotskin.layout.grown_tree import grown_tree as grown_tree
from robotskin.viewer.network_view import NO_PATH, Flags
from robotskin.viewer.session_view import Integers


def cable_names(layout: Layout) -> list[str]:
    """Of each cable in `layout.section_unit_ports`: section unit and port, as everywhere where there is little room."""
    return [cable.label for cable in CellNetwork.of_layout(layout).cables]


def wired_tree(layout: Layout) -> tuple[Integers, Integers]:
    """The tree that a whole skin grows: every cell by the fewest hops to a cable.

    Returns the cable (N,) of each cell as an index into `layout.section_unit_ports`, -1 where no way leads to one, and
    its parent (N,), the next cell on that way, -1 at the cable itself.
    """
    count = len(layout)
    cable = np.full(count, -1)
    parent = np.full(count, -1)
    if not layout.section_unit_ports:
        return cable, parent
    roots = np.array([place.cell for place in layout.section_unit_ports])
    edges = layout.edges()
    graph = coo_array((np.ones(len(edges)), (edges[:, 0], edges[:, 2])), shape=(count, count)).tocsr()
    hops, previous, source = dijkstra(
        graph, directed=False, unweighted=True, indices=roots, min_only=True, return_predecessors=True
    )
    reached = np.isfinite(hops)
    cable_at = np.full(count, -1)
    cable_at[roots] = np.arange(len(roots))
    cable[reached] = cable_at[source[reached]]
    parent[reached] = np.maximum(previous[reached], -1)
    return cable, parent


def follow(parent: Integers, layout: Layout) -> Integers:
    """(N,) the cable at the end of each cell's way along `parent` (N,), -1 where the way ends at none."""
    end = _ends(parent)
    cable_at = np.full(len(parent), -1)
    for index, place in enumerate(layout.section_unit_ports):
        cable_at[place.cell] = index
    return np.where(np.asarray(parent)[end] < 0, cable_at[end], -1)


def follow_ports(parent_port: Integers, alive: Flags, cut: Flags, layout: Layout) -> Integers:
    """(N,) the cable at the end of each living cell's way over wires that work, `NO_PATH` where it ends at none.

    Args:
        parent_port: (N,) the port to each cell's parent, 1 to 4; 0 while it has none.
        alive: (N,); cut: (N, 4) wires that carry nothing.
    """
    cells = np.arange(len(layout))
    port = np.asarray(parent_port, dtype=int) - 1
    works = alive & (port >= 0) & ~cut[cells, port]
    parent = np.where(works, layout.neighbours[cells, port, 0], -1)
    cable_at = np.full((len(layout), 4), NO_PATH)
    for index, place in enumerate(layout.section_unit_ports):
        cable_at[place.cell, place.cell_port - 1] = index
    parent = np.where((parent >= 0) & alive[parent], parent, -1)
    end = _ends(parent)
    plugged = np.where(works, cable_at[cells, port], NO_PATH)
    return np.where(parent[end] < 0, plugged[end], NO_PATH)


def _ends(parent: Integers) -> Integers:
    """(N,) the last cell on each cell's way along `parent` (N,), -1 where a way ends; one of its cells for a ring."""
    cells = np.arange(len(parent))
    end = np.where(parent >= 0, parent, cells)
    for _ in range(len(cells).bit_length()):  # Each turn doubles the hops taken.
        end = end[end]
    return end


def fair_shares(alive: Flags, cut: Flags, layout: Layout) -> Integers:
    """(P,) cells each cable would carry if those that share a piece of skin shared its cells equally, rounded up.

    A piece is what wires that work hold together; a cable that is cut, or ends at a dead cell, has no share.

    Args:
        alive: (N,); cut: (N, 4) wires that carry nothing.
    """
    count = len(layout)
    edges = layout.edges()
    works = alive[edges[:, 0]] & alive[edges[:, 2]] & ~cut[edges[:, 0], edges[:, 1]] & ~cut[edges[:, 2], edges[:, 3]]
    ends = edges[works]
    graph = coo_array((np.ones(len(ends)), (ends[:, 0], ends[:, 2])), shape=(count, count))
    pieces, piece = connected_components(graph, directed=False)
    size = np.bincount(piece[alive], minlength=pieces)
    cell = np.array([place.cell for place in layout.section_unit_ports], dtype=int)
    port = np.array([place.cell_port - 1 for place in layout.section_unit_ports], dtype=int)
    plugged = alive[cell] & ~cut[cell, port]
    cables = np.bincount(piece[cell[plugged]], minlength=pieces)
    return np.where(plugged, -(-size[piece[cell]] // np.maximum(cables[piece[cell]], 1)), 0)
