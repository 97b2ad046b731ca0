# SPDX-License-Identifier: Apache-2.0
"""Which cells hang together: from neighbour lists to patches, root cells and shortest paths (paper, II-C).

In: neighbour lists as the network reports them. Out: `Topology`, and every report that contradicts another one.
"""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Iterator
from dataclasses import dataclass
from typing import Literal

import numpy as np
from numpy.typing import ArrayLike, NDArray
from scipy import sparse
from scipy.sparse import csgraph

from robotskin.layout.cell import FLAT_PARTNER, PORTS
from robotskin.selfconfig.topology.neighbours import NeighbourLists

DefectKind = Literal["duplicate cell", "missing neighbour", "one-way", "contradictory", "ambiguous ports", "itself"]


@dataclass(frozen=True)
class TopologyDefect:
    """A neighbour report that does not fit the others. cell, neighbour: keys; port: 1 to 4; used: the edge was kept."""

    kind: DefectKind
    cell: int
    port: int
    neighbour: int
    used: bool

    def __str__(self) -> str:
        outcome = "kept" if self.used else "left out"
        return f"cell {self.cell}, port {self.port}, neighbour {self.neighbour}: {self.kind}; {outcome}"


@dataclass(frozen=True, eq=False)
class Topology:
    """Patches, roots and shortest paths; N cells, E edges, P patches.

    cell: (N,) keys; edges: (E, 4) rows of cell, port index 0 to 3, neighbour, its port index, cells as row numbers of
    `cell` and each edge once; one_way: (E,) whether only one of the two cells reported the edge.
    patch: (N,) index of the patch; root: (P,) its root cell; hops: (N,) edges to the root;
    parent: (N,) next cell on the shortest path to the root, -1 at roots; parent_edge: (N,) the edge to it, or -1.
    """

    cell: NDArray[np.int64]
    edges: NDArray[np.int64]
    one_way: NDArray[np.bool_]
    patch: NDArray[np.int64]
    root: NDArray[np.int64]
    hops: NDArray[np.int64]
    parent: NDArray[np.int64]
    parent_edge: NDArray[np.int64]
    defects: tuple[TopologyDefect, ...]

    def loop_edges(self) -> NDArray[np.int64]:
        """(L,) numbers of the edges that are on no shortest path: each closes a loop."""
        on_path = np.zeros(len(self.edges), dtype=bool)
        on_path[self.parent_edge[self.parent_edge >= 0]] = True
        return np.flatnonzero(~on_path)

    def path_to_root(self, cell: int) -> list[int]:
        """Cells (row numbers) from a cell to its root, both included."""
        path = [int(cell)]
        while self.parent[path[-1]] >= 0:
            path.append(int(self.parent[path[-1]]))
        return path

    def cells_of(self, patch: int) -> NDArray[np.int64]:
        """Row numbers of the cells of a patch.

        Raises:
            ValueError: no such patch.
        """
        if not 0 <= patch < len(self.root):
            raise ValueError(f"patch {patch}: must be 0 to {len(self.root) - 1}")
        return np.flatnonzero(self.patch == patch)

    def within(self, patch: int) -> tuple[NDArray[np.int64], NDArray[np.int64]]:
        """(N,) each cell's row in `cells_of(patch)`, -1 elsewhere; (E, 4) the patch's edges by it, lower port first.

        Raises:
            ValueError: no such patch.
        """
        cells = self.cells_of(patch)
        row = np.full(len(self.cell), -1)
        row[cells] = np.arange(len(cells))
        edges = self.edges[self.patch[self.edges[:, 0]] == patch].copy()
        edges[:, [0, 2]] = row[edges[:, [0, 2]]]
        turned = edges[:, 1] > edges[:, 3]
        edges[turned] = edges[turned][:, [2, 3, 0, 1]]
        return row, edges


def explore(lists: NeighbourLists, edge_weight: ArrayLike | None = None) -> Topology:
    """Patches, root cells and shortest paths from neighbour lists.

    The lists make a directed graph; its connected components are the patches; the root of a patch is the cell with
    the least accumulated shortest path to all others (ties: the first in the lists). Defects are reported and survived:
    an edge named from one side only is kept if nothing contradicts it and the other port is known.

    Args:
        lists: what the network reports.
        edge_weight: (E,) length of each edge in the order of `Topology.edges`, for a second pass once edges have been
            measured (the released software weighs them by their rotation error); every edge counts 1 without it.

    Raises:
        ValueError: no cells, or weights that are not E positive numbers.
    """
    if len(lists) == 0:
        raise ValueError("neighbour lists: no cell reported anything; is the network up?")
    rows, defects = _distinct_cells(lists)
    edges, one_way, more = _agree(_claims(lists, rows, defects))
    defects += more
    cells = lists.cell[rows]
    count = len(cells)
    weight = np.ones(len(edges)) if edge_weight is None else np.asarray(edge_weight, dtype=float)
    if weight.shape != (len(edges),) or not (weight > 0).all():
        raise ValueError(f"edge_weight: shape {weight.shape}: must be {len(edges)} positive numbers")
    graph = _graph(edges, weight, count)
    patches, patch = csgraph.connected_components(graph, directed=False)
    members = (np.flatnonzero(patch == index) for index in range(patches))
    root = np.array([_central_cell(graph, cells_) for cells_ in members], dtype=np.int64)
    parent = _parents(graph, root)
    parent_edge = _edges_to(parent, edges, weight)
    return Topology(
        cell=cells,
        edges=edges,
        one_way=one_way,
        patch=patch.astype(np.int64),
        root=root,
        hops=_depth(parent),
        parent=parent,
        parent_edge=parent_edge,
        defects=tuple(defects),
    )


def _distinct_cells(lists: NeighbourLists) -> tuple[NDArray[np.int64], list[TopologyDefect]]:
    """The first report of every cell, and a defect for each further one."""
    _, first = np.unique(lists.cell, return_index=True)
    repeated = np.setdiff1d(np.arange(len(lists)), first)
    return np.sort(first), [TopologyDefect("duplicate cell", int(lists.cell[row]), 0, 0, False) for row in repeated]


@dataclass(frozen=True)
class _Claim:
    """One directed edge: port index of a cell says that a neighbour's port is plugged in (-1: port not told)."""

    cell: int
    port: int
    neighbour: int
    neighbour_port: int
    keys: tuple[int, int]

    def defect(self, kind: DefectKind, used: bool) -> TopologyDefect:
        return TopologyDefect(kind, self.keys[0], self.port + 1, self.keys[1], used)


def _claims(lists: NeighbourLists, rows: NDArray[np.int64], defects: list[TopologyDefect]) -> list[_Claim]:
    """Every directed edge whose two cells exist; the others become defects."""
    index_of = {int(lists.cell[row]): index for index, row in enumerate(rows)}
    claims = []
    faces = lists.faces_cell()
    for index, row in enumerate(rows):
        key = int(lists.cell[row])
        for port in np.flatnonzero(faces[row]):
            other = int(lists.neighbour[row, port])
            told = int(lists.port[row, port]) - 1
            claim = _Claim(index, int(port), index_of.get(other, -1), told if 0 <= told < PORTS else -1, (key, other))
            if claim.neighbour < 0:
                defects.append(claim.defect("missing neighbour", False))
            elif claim.neighbour == index:
                defects.append(claim.defect("itself", False))
            else:
                claims.append(claim)
    return claims


def _tell_ports(claims: list[_Claim]) -> tuple[list[_Claim], list[TopologyDefect]]:
    """Fill in ports that the network did not tell, from the port by which the neighbour names the cell."""
    back: dict[tuple[int, int], list[int]] = defaultdict(list)
    forth: dict[tuple[int, int], list[int]] = defaultdict(list)
    for claim in claims:
        back[claim.neighbour, claim.cell].append(claim.port)
        forth[claim.cell, claim.neighbour].append(claim.port)
    told, defects = [], []
    for claim in claims:
        port = claim.neighbour_port
        if port < 0:
            ports = back[claim.cell, claim.neighbour]
            duplicates = forth[claim.cell, claim.neighbour]
            if len(ports) == 1 and len(duplicates) == 1:
                port = ports[0]
            elif int(FLAT_PARTNER[claim.port]) in ports:
                # Two cells that share two hinges: only the flat pairing lets both close.
                port = int(FLAT_PARTNER[claim.port])
                defects.append(claim.defect("ambiguous ports", True))
            else:
                defects.append(claim.defect("one-way" if not ports else "ambiguous ports", False))
                continue
        told.append(_Claim(claim.cell, claim.port, claim.neighbour, port, claim.keys))
    return told, defects


def _agree(claims: list[_Claim]) -> tuple[NDArray[np.int64], NDArray[np.bool_], list[TopologyDefect]]:
    """Edges that both cells report, then those that one reports and no other contradicts."""
    claims, defects = _tell_ports(claims)
    forward = {(claim.cell, claim.port): (claim.neighbour, claim.neighbour_port) for claim in claims}
    edges: list[tuple[int, int, int, int]] = []
    single: list[_Claim] = []
    taken: set[tuple[int, int]] = set()
    for claim in claims:
        here, there = (claim.cell, claim.port), (claim.neighbour, claim.neighbour_port)
        if forward.get(there) == here:
            if here < there:
                edges.append((*here, *there))
                taken |= {here, there}
        else:
            single.append(claim)
    wanted: dict[tuple[int, int], int] = defaultdict(int)
    for claim in single:
        wanted[claim.cell, claim.port] += 1
        wanted[claim.neighbour, claim.neighbour_port] += 1
    mutual = len(edges)
    for claim in single:
        here, there = (claim.cell, claim.port), (claim.neighbour, claim.neighbour_port)
        free = there not in taken and wanted[here] == 1 and wanted[there] == 1
        if free:
            edges.append((*here, *there) if here < there else (*there, *here))
        defects.append(claim.defect("one-way" if free else "contradictory", free))
    table = np.array(edges, dtype=np.int64).reshape(-1, 4)
    one_way = np.arange(len(table)) >= mutual
    order = np.lexsort(table.T[::-1])
    return table[order], one_way[order], defects


def _graph(edges: NDArray[np.int64], weight: NDArray[np.float64], count: int) -> sparse.csr_array:
    """(N, N) symmetric; between two cells with two hinges the shorter edge counts."""
    order = np.lexsort((weight, edges[:, 2], edges[:, 0]))
    _, first = np.unique(edges[order][:, [0, 2]], axis=0, return_index=True)
    pairs, values = edges[order[first]][:, [0, 2]], weight[order[first]]
    both = np.concatenate([pairs, pairs[:, ::-1]])
    return sparse.csr_array((np.tile(values, 2), (both[:, 0], both[:, 1])), shape=(count, count))


def _central_cell(graph: sparse.csr_array, cells: NDArray[np.int64]) -> int:
    """The cell of a connected patch with the least accumulated shortest path; of equals the first.

    Dijkstra from every cell would take 15 s for ten thousand. But the accumulated path S changes by at most n d(u, v)
    between two of n cells, so one Dijkstra from u also bounds S(v) from below for every v, and cells whose bound is
    above the best S found need none: a few hundred remain.
    """
    patch = graph[cells][:, cells]
    count = len(cells)
    known = np.full(count, np.inf)
    bound = np.zeros(count)
    while True:
        # Of an inexact sum of weights the last digits do not decide.
        open_cells = np.flatnonzero(~np.isfinite(known) & (bound <= known.min() * (1 + 1e-12)))
        if len(open_cells) == 0:
            return int(cells[np.flatnonzero(known <= known.min() * (1 + 1e-12))[0]])
        # Single steps while each moves the bounds far, then as many at once as remain.
        at_once = 1 if np.isfinite(known).sum() < 16 else 32
        sources = open_cells[np.argsort(bound[open_cells], kind="stable")[:at_once]]
        length = csgraph.dijkstra(patch, directed=False, indices=sources)
        known[sources] = length.sum(axis=1)
        bound = np.maximum(bound, (known[sources][:, None] - count * length).max(axis=0))


def _parents(graph: sparse.csr_array, root: NDArray[np.int64]) -> NDArray[np.int64]:
    """(N,) next cell towards the nearest root, -1 at roots."""
    _, before, _ = csgraph.dijkstra(graph, directed=False, indices=root, min_only=True, return_predecessors=True)
    return np.where(before < 0, -1, before).astype(np.int64)


def _edges_to(parent: NDArray[np.int64], edges: NDArray[np.int64], weight: NDArray[np.float64]) -> NDArray[np.int64]:
    """(N,) number of the edge between each cell and its parent; the shortest where there are two."""
    number: dict[tuple[int, int], int] = {}
    for row in np.argsort(weight, kind="stable"):
        a, b = int(edges[row, 0]), int(edges[row, 2])
        number.setdefault((a, b), int(row))
        number.setdefault((b, a), int(row))
    return np.array([number[cell, int(up)] if up >= 0 else -1 for cell, up in enumerate(parent)], dtype=np.int64)


def _depth(parent: NDArray[np.int64]) -> NDArray[np.int64]:
    """(N,) edges to the root."""
    depth = np.zeros(len(parent), dtype=np.int64)
    ahead = parent.copy()
    while (ahead >= 0).any():
        depth += ahead >= 0
        ahead = np.where(ahead >= 0, parent[ahead], -1)
    return depth


def walk_out(parent: NDArray[np.int64], hops: NDArray[np.int64]) -> Iterator[int]:
    """Cells in an order in which every cell comes after its parent."""
    return (int(cell) for cell in np.argsort(hops, kind="stable"))
