# SPDX-License-Identifier: Apache-2.0
import itertools
import json
import time
from pathlib import Path

import networkx as nx
import numpy as np
import pytest

from robotskin.layout.cell import FLAT_PARTNER
from robotskin.selfconfig.topology.neighbours import NeighbourLists
from robotskin.selfconfig.topology.topology import explore


def lattice(rows: int, columns: int, random: np.random.Generator, missing: float = 0.0) -> np.ndarray:
    """(N, 4, 2) neighbours of a flat lattice without some of its edges, its cells in a random order."""
    cell = random.permutation(rows * columns).reshape(rows, columns)
    table = np.tile([-1, 0], (rows * columns, 4, 1))
    for port, a, b in ((0, cell[:, :-1], cell[:, 1:]), (1, cell[:-1], cell[1:])):
        for here, there in zip(a.ravel(), b.ravel(), strict=True):
            if random.random() >= missing:
                partner = FLAT_PARTNER[port]
                table[here, port] = there, partner + 1
                table[there, partner] = here, port + 1
    return table


def truth(table: np.ndarray) -> nx.Graph:
    graph = nx.Graph()
    graph.add_nodes_from(range(len(table)))
    graph.add_edges_from((i, int(j)) for i, row in enumerate(table) for j, _ in row if j >= 0)
    return graph


@pytest.mark.parametrize("missing", [0.0, 0.3, 0.6])
def test_patches_roots_and_paths_are_those_of_an_independent_library(seed: int, missing: float) -> None:
    table = lattice(9, 11, np.random.default_rng(seed), missing)
    topology = explore(NeighbourLists.from_indices(np.arange(99) + 1, table))
    graph = truth(table)
    assert topology.defects == ()
    assert len(topology.edges) == graph.number_of_edges()
    components = {frozenset(component) for component in nx.connected_components(graph)}
    assert {frozenset(topology.cells_of(patch).tolist()) for patch in range(len(topology.root))} == components
    for patch, root in enumerate(topology.root):
        far = {int(cell): sum(nx.single_source_shortest_path_length(graph, int(cell)).values())
               for cell in topology.cells_of(patch)}  # fmt: skip
        assert far[int(root)] == min(far.values())
        for cell, hops in nx.single_source_shortest_path_length(graph, int(root)).items():
            path = topology.path_to_root(cell)
            assert path[-1] == root
            assert len(path) - 1 == hops == topology.hops[cell]
            assert all(graph.has_edge(a, b) for a, b in itertools.pairwise(path))
    assert len(topology.loop_edges()) == graph.number_of_edges() - len(table) + len(components)


def test_weights_move_root_and_paths(seed: int) -> None:
    random = np.random.default_rng(seed)
    lists = NeighbourLists.from_indices(np.arange(30) + 1, lattice(5, 6, random))
    weight = random.uniform(0.1, 3.0, len(explore(lists).edges))
    topology = explore(lists, weight)
    graph = nx.Graph()
    for edge, length in zip(topology.edges, weight, strict=True):
        graph.add_edge(int(edge[0]), int(edge[2]), weight=length)
    far = {cell: sum(nx.single_source_dijkstra_path_length(graph, cell).values()) for cell in graph}
    root = int(topology.root[0])
    assert far[root] == pytest.approx(min(far.values()))
    for cell in graph:
        path = topology.path_to_root(cell)
        length = sum(graph[a][b]["weight"] for a, b in itertools.pairwise(path))
        assert length == pytest.approx(nx.dijkstra_path_length(graph, cell, root))


def test_ports_that_the_network_does_not_tell_are_found(seed: int) -> None:
    table = lattice(6, 6, np.random.default_rng(seed), 0.2)
    told = NeighbourLists.from_indices(np.arange(36) + 1, table)
    untold = NeighbourLists(told.cell, told.neighbour)
    assert np.array_equal(explore(told).edges, explore(untold).edges)


def test_every_defect_is_named_and_survived(seed: int) -> None:
    lists = NeighbourLists.from_indices(np.arange(12) + 1, lattice(3, 4, np.random.default_rng(seed)))
    flawless = explore(lists)
    cell, neighbour, port = lists.cell.copy(), lists.neighbour.copy(), lists.port.copy()
    a, p, b, q = flawless.edges[0]
    neighbour[b, q] = port[b, q] = 0  # one-way: b forgets a
    c, r, d, _ = next(edge for edge in flawless.edges if not {a, b} & {edge[0], edge[2]})
    neighbour[c, r] = 999  # missing: c names a cell that never reported, so d's report of c is contradicted
    free_cell, free_port = next(
        (int(i), int(k)) for i, k in np.argwhere(neighbour == 0) if i not in (a, b, c, d) and lists.neighbour[i, k] == 0
    )
    neighbour[free_cell, free_port] = cell[free_cell]  # itself
    lists = NeighbourLists(
        np.append(cell, cell[0]), np.vstack([neighbour, neighbour[0]]), np.vstack([port, port[0]])
    )  # the first cell reports twice
    topology = explore(lists)
    named = {(defect.kind, defect.cell, defect.port, defect.used) for defect in topology.defects}
    assert ("one-way", int(cell[a]), int(p) + 1, True) in named
    assert ("missing neighbour", int(cell[c]), int(r) + 1, False) in named
    assert ("itself", int(cell[free_cell]), free_port + 1, False) in named
    assert ("duplicate cell", int(cell[0]), 0, False) in named
    assert any(defect.neighbour == cell[c] and defect.cell == cell[d] for defect in topology.defects)
    kept = {tuple(edge) for edge in topology.edges}
    assert (a, p, b, q) in kept
    assert topology.one_way[[tuple(edge) == (a, p, b, q) for edge in topology.edges]].all()
    assert len(topology.cell) == 12


def test_two_cells_that_claim_one_port_are_contradictory() -> None:
    # Cells 2 and 3 both say that they are plugged into port 1 of cell 1, which says that it is cell 2.
    lists = NeighbourLists([1, 2, 3], [[2, 0, 0, 0], [0, 0, 0, 1], [0, 0, 0, 1]],
                           [[4, 0, 0, 0], [0, 0, 0, 1], [0, 0, 0, 1]])  # fmt: skip
    topology = explore(lists)
    assert [(defect.kind, defect.cell) for defect in topology.defects] == [("contradictory", 3)]
    assert topology.edges.tolist() == [[0, 0, 1, 3]]
    assert topology.patch.tolist() == [0, 0, 1]


def test_random_lists_are_never_fatal(seed: int) -> None:
    random = np.random.default_rng(seed)
    for _ in range(200):
        count = int(random.integers(1, 12))
        lists = NeighbourLists(
            random.integers(1, 14, count), random.integers(0, 14, (count, 4)), random.integers(0, 6, (count, 4))
        )
        topology = explore(lists)
        used = [tuple(edge[:2]) for edge in topology.edges] + [tuple(edge[2:]) for edge in topology.edges]
        assert len(used) == len(set(used)), "a port joins two edges"
        assert (topology.parent[topology.root] == -1).all()


def test_no_report_at_all_is_an_error() -> None:
    with pytest.raises(ValueError, match="no cell reported"):
        explore(NeighbourLists(np.zeros(0), np.zeros((0, 4))))


def test_ten_thousand_cells_in_seconds(seed: int) -> None:
    lists = NeighbourLists.from_indices(np.arange(10_000) + 1, lattice(100, 100, np.random.default_rng(seed)))
    start = time.process_time()
    topology = explore(lists)
    assert time.process_time() - start < 10.0
    assert topology.hops.max() == 100


def test_published_roots_are_most_central(shared_data: Path) -> None:
    loops = 0
    for file in sorted((shared_data / "tum_patches").glob("*.json")):
        patch = json.loads(file.read_text())["sc_patch"]
        lists = NeighbourLists(
            [row["node_id"] for row in patch["sc_neighs"]], [row["neighbor_ids"] for row in patch["sc_neighs"]]
        )
        topology = explore(lists)
        # The released software weighs edges by their rotation error, so its root may be a step off centre.
        graph = nx.Graph((int(edge[0]), int(edge[2])) for edge in topology.edges)
        far = {cell: sum(nx.single_source_shortest_path_length(graph, cell).values()) for cell in graph}
        published = topology.cell.tolist().index(patch["root_sc_id"])
        assert far[published] <= far[int(topology.root[0])] + 1
        assert {defect.kind for defect in topology.defects} <= {"missing neighbour"}
        loops += len(topology.loop_edges())
    assert loops == 6
