# SPDX-License-Identifier: Apache-2.0
"""Laws of the limits: flow equals cut, no forest beats its bound, brute force agrees, and advice keeps its promise."""

from collections.abc import Iterator
from itertools import product

import numpy as np
import pytest

from robotskin.errors import InputError
from robotskin.layout.cell_network import CellNetwork
from robotskin.layout.network_limits import (
    best_forest,
    bottleneck,
    hops_to_cables,
    least_depth_of_even_loads,
    least_depths,
    least_fullest,
)
from robotskin.layout.network_limits.annealing import annealed_forest, nearest_roots
from robotskin.layout.network_limits.exact import exact_forest
from robotskin.layout.network_limits.flow import LINE_FRAMES_PER_S, carried, cut_of
from robotskin.layout.network_limits.trees import roots_and_neighbours
from robotskin_lab.bench.network_set import skins
from robotskin_lab.network_limits import decide, least_depth_of_load, least_load_within, load_within

MANY = 100_000
"""Trials that decide any small skin."""


@pytest.fixture
def generator(seed: int) -> np.random.Generator:
    return np.random.default_rng(seed)


def small_network(generator: np.random.Generator, cells: int, cables: int) -> CellNetwork:
    """A connected random graph of cells with at most four ports each, and cables at drawn free ports."""
    while True:
        neighbours = np.full((cells, 4, 2), (-1, 0), dtype=np.int32)
        free = [[1, 2, 3, 4] for _ in range(cells)]
        pairs = [(int(generator.integers(cell)), cell) for cell in range(1, cells)]
        pairs += [tuple(sorted(generator.choice(cells, 2, replace=False).tolist())) for _ in range(cells // 2)]
        for a, b in dict.fromkeys(pairs):
            if free[a] and free[b]:
                port_a, port_b = free[a].pop(), free[b].pop()
                neighbours[a, port_a - 1], neighbours[b, port_b - 1] = (b, port_b), (a, port_a)
        network = CellNetwork(
            "small",
            neighbours,
            (),
            np.arange(1, cells + 1, dtype=np.uint16),
            np.ones(cells, dtype=np.uint16),
            np.zeros(cells, dtype=np.int32),
            np.zeros(cells, dtype=np.int32),
            np.zeros((cells, 3)),
        )
        open_cells = [cell for cell in range(cells) if free[cell]]
        if network.part.max() == 0 and len(open_cells) >= cables:
            chosen = generator.choice(open_cells, cables, replace=False)
            return network.with_cables([(int(cell), free[cell][0]) for cell in chosen])


def near_and_roots(network: CellNetwork) -> tuple[list[list[int]], list[int]]:
    near = [[int(other) for other in row if other >= 0] for row in network.neighbours[:, :, 0]]
    return near, [int(root) for root in network.roots]


def hangs_together(near: list[list[int]], owner: list[int], root: int) -> bool:
    tree = owner[root]
    seen, queue = {root}, [root]
    for cell in queue:
        for other in near[cell]:
            if owner[other] == tree and other not in seen:
                seen.add(other)
                queue.append(other)
    return len(seen) == owner.count(tree)


def all_owners(near: list[list[int]], roots: list[int]) -> Iterator[tuple[list[int], int]]:
    """Every way to give each cell to a tree, whether trees hang together or not, and the load of the fullest."""
    others = [cell for cell in range(len(near)) if cell not in roots]
    owner = [0] * len(near)
    for tree, root in enumerate(roots):
        owner[root] = tree
    for choice in product(range(len(roots)), repeat=len(others)):
        for cell, tree in zip(others, choice, strict=True):
            owner[cell] = tree
        yield owner, max(owner.count(tree) for tree in range(len(roots)))


def brute_force(near: list[list[int]], roots: list[int]) -> int:
    """Load of the fullest tree of the best forest, by trying all."""
    best = len(near)
    for owner, fullest in all_owners(near, roots):
        if fullest < best and all(hangs_together(near, owner, root) for root in roots):
            best = fullest
    return best


def depth_of_tree(near: list[list[int]], owner: list[int], root: int) -> int:
    """Hops of the deepest cell, the cable included, through cells of the tree alone; 1000 if one has no way."""
    hops, queue = {root: 1}, [root]
    for cell in queue:
        for other in near[cell]:
            if owner[other] == owner[root] and other not in hops:
                hops[other] = hops[cell] + 1
                queue.append(other)
    return max(hops.values()) if len(hops) == owner.count(owner[root]) else 1000


def fullest_by_depth(near: list[list[int]], roots: list[int]) -> dict[int, int]:
    """By depth of the forest, the load of the fullest tree of the best one so deep, by trying all."""
    best: dict[int, int] = {}
    for owner, fullest in all_owners(near, roots):
        depth = max(depth_of_tree(near, owner, root) for root in roots)
        best[depth] = min(best.get(depth, len(near)), fullest)
    return best


def test_maximum_flow_equals_minimum_cut(generator):
    """Brute force over all sets of cells names the cut; and just that rate flows, not a frame more."""
    for _ in range(6):
        network = small_network(generator, 10, int(generator.integers(1, 4)))
        cut = bottleneck(network)
        sets = [cut_of(network, np.array(inside)) for inside in product([False, True], repeat=10) if any(inside)]
        least = min(candidate.lines / len(candidate.cells) for candidate in sets)
        assert cut.lines / len(cut.cells) == pytest.approx(least, abs=1e-12)
        assert cut.rate_hz == pytest.approx(least * LINE_FRAMES_PER_S)
        cells = np.arange(10)
        assert carried(network, cells, cut.lines, len(cut.cells)) is None
        assert carried(network, cells, cut.lines * 100 + 1, len(cut.cells) * 100) is not None


def test_the_best_forest_is_what_brute_force_finds(generator):
    for _ in range(6):
        network = small_network(generator, 9, int(generator.integers(2, 4)))
        near, roots = near_and_roots(network)
        truth = brute_force(near, roots)
        forest = best_forest(network, 0)
        owner, bound = exact_forest(near, roots, least_fullest(near, roots), len(near))
        assert forest.fullest == truth
        assert forest.proven
        assert least_fullest(near, roots) <= truth
        assert bound == truth
        assert max(owner.count(tree) for tree in range(len(roots))) == truth
        assert all(hangs_together(near, owner, root) for root in roots)


def test_no_forest_undercuts_the_bound_of_its_depth(generator):
    """Brute force over all forests: bounds on load and depth never exceed the best, and with trials enough are it."""
    for _ in range(12):
        network = small_network(generator, 10, int(generator.integers(2, 4)))
        near, roots = near_and_roots(network)
        best = fullest_by_depth(near, roots)
        shallowest = int(least_depths(network).max())
        for deepest in range(shallowest, shallowest + 4):
            truth = min(load for depth, load in best.items() if depth <= deepest)
            quick, few, all_of_it = (least_load_within(near, roots, deepest, len(near), n) for n in (0, 20, MANY))
            assert least_fullest(near, roots) <= quick <= few <= all_of_it == truth
            within = load_within(near, roots, deepest, len(near), MANY, steps_per_cell=int(generator.integers(40)))
            assert within.least == within.fullest == truth
            assert all(depth_of_tree(near, within.owner, root) <= deepest for root in roots)
            for load in range(1, len(near) + 1):
                decision = decide(near, roots, deepest, load, MANY)
                assert decision.refuted == (load < truth)
                if not decision.refuted:
                    assert max(decision.owner.count(tree) for tree in range(len(roots))) <= load
                    assert all(depth_of_tree(near, decision.owner, root) <= deepest for root in roots)
            for load in range(truth, len(near) + 1):
                for trials in (0, 20, MANY):
                    assert least_depth_of_load(near, roots, load, shallowest, trials) <= deepest


def test_a_depth_forbids_even_loads_that_a_greater_one_allows():
    """In a row a cable serves all that is behind it; in a ring cables share, if trees may be deep enough."""
    near = [[1], [0, 2], [1, 3], [2, 4], [3, 5], [4]]
    assert [least_load_within(near, [0, 5], deepest, 6) for deepest in (3, 4)] == [3, 3]
    near = [[1], [0, 2], [1, 3], [2, 4], [3, 5], [4, 6], [5, 7], [6]]
    assert [least_load_within(near, [0, 2], deepest, 8) for deepest in (6, 8)] == [6, 6]
    # A ring of eight with its cables side by side: even at a depth of four, and no forest is shallower.
    ring = [[(cell - 1) % 8, (cell + 1) % 8] for cell in range(8)]
    assert least_load_within(ring, [0, 1], 4, 8) == 4
    assert least_depth_of_load(ring, [0, 1], 4, 2) == 4
    assert least_depth_of_load(ring, [0, 1], 3, 2) is None


@pytest.mark.parametrize("kind", ["sheet", "cylinder", "ring_12", "ur5"])
def test_a_forest_is_one_and_keeps_to_its_bounds(kind, seed):
    network = skins(kind, 3, seed % 100)
    for part in range(int(network.part.max()) + 1):
        forest = best_forest(network, part, steps_per_cell=40)
        near, _ = near_and_roots(network)
        owner = [-1] * len(network)
        for cell, tree in zip(forest.cells, forest.owner, strict=True):
            owner[cell] = int(tree)
        for tree, cable in enumerate(forest.cables):
            root = int(network.roots[cable])
            assert owner[root] == tree
            members = [cell for cell in forest.cells if owner[cell] == tree]
            seen, queue = {root}, [root]
            for cell in queue:
                new = [other for other in near[cell] if owner[other] == tree and other not in seen]
                seen.update(new)
                queue += new
            assert seen == set(members)
        assert forest.loads.sum() == len(forest.cells)
        assert forest.fullest >= forest.bound >= -(-len(forest.cells) // len(forest.cables))
        assert forest.fullest >= bottleneck(network, part).cells_per_line


def test_most_compact_skins_are_even_to_the_cell(seed):
    chosen = [(kind, (seed + k) % 100) for kind in ("sheet", "sheared_sheet") for k in range(2)]
    forests = [best_forest(skins(kind, 3, which), 0) for kind, which in chosen]
    assert [forest.fullest for forest in forests] == [66] * 4


def bridged_patches(bridges: list[int]) -> tuple[list[list[int]], int]:
    """Two patches of 3 by 3 cells, joined at these of their rows by a bridge of one cell each; and the cells."""
    patches = [(side, row, column) for side in range(2) for row in range(3) for column in range(3)]
    number = {place: cell for cell, place in enumerate(patches)}
    pairs = [
        (number[place], number[other])
        for place in patches
        for other in ((place[0], place[1] + 1, place[2]), (place[0], place[1], place[2] + 1))
        if other in number
    ]
    for bridge, row in enumerate(bridges, start=len(patches)):
        pairs += [(number[0, row, 2], bridge), (bridge, number[1, row, 0])]
    near: list[list[int]] = [[] for _ in range(len(patches) + len(bridges))]
    for first, second in pairs:
        near[first].append(second)
        near[second].append(first)
    return near, len(near)


def test_a_depth_that_no_forest_has_is_refused():
    line = [[1], [0, 2], [1, 3], [2, 4], [3]]
    assert load_within(line, [0], 5, 5, MANY).owner == [0] * 5
    with pytest.raises(InputError, match="deepest: 2 hops: shortest paths have 5"):
        load_within(line, [0], 2, 5, MANY)


def test_a_bridge_belongs_to_one_tree_and_all_behind_it_too():
    """One bridge of one cell: ten cells and the way to them are one cable's, though frames could be split evenly."""
    near, count = bridged_patches([1])
    roots = [0, 6]
    assert least_fullest(near, roots) == 10
    # The way from a corner to the bridge has four cells: 14 cells, the last of them seven hops behind the bridge's end.
    assert load_within(near, roots, 9, count, MANY).least == 14
    assert load_within(near, roots, 9, count, MANY).fullest == 14
    # Two bridges at the rows of the cables share all evenly, as deep as the patches are long.
    near, count = bridged_patches([0, 2])
    assert [load_within(near, roots, deepest, count, MANY).fullest for deepest in (8, 9)] == [10, 10]
    assert least_load_within(near, roots, 8, count, MANY) == 10


def test_cables_that_share_their_only_way_in_cannot_share_what_is_behind_it():
    """Two cables' cells touch one cell only, with a row behind it: one of them serves all, at any depth."""
    near = [[2], [2], [0, 1, 3], [2, 4], [3, 5], [4, 6], [5]]
    assert least_fullest(near, [0, 1]) == 4
    assert least_load_within(near, [0, 1], len(near), len(near), MANY) == 6
    assert least_depth_of_load(near, [0, 1], 5, 6, MANY) is None
    assert least_depth_of_load(near, [0, 1], 6, 6, MANY) == 6


@pytest.mark.parametrize("which", [72, 45])
def test_a_ring_of_patches_is_decided(which):
    """Within four hops more than the fewest, the trees of ring 72 leave 87 cells to a cable at the least; of 45, 66.

    A forest is found with just as many, and each is one.
    """
    least = {72: 87, 45: 66}[which]
    network = skins("ring_12", 3, which)
    near, roots = roots_and_neighbours(network, 0)
    deepest = int(least_depths(network).max()) + 4
    found = load_within(near, roots, deepest, len(near), 10_000, enough=66)
    assert found.least == found.fullest == least
    assert all(depth_of_tree(near, found.owner, root) <= deepest for root in roots)


@pytest.mark.parametrize("kind", ["sheet", "cylinder", "ring_12"])
def test_annealing_keeps_to_its_depth_and_repeats(kind, seed):
    """A forest of the depth asked for, no worse than shortest paths; the same seed gives the same one."""
    network = skins(kind, 4, seed % 100)
    near, roots = roots_and_neighbours(network, 0)
    shallowest = int(least_depths(network).max())
    paths = nearest_roots(near, roots)
    for deepest in (shallowest, shallowest + 2):
        owner, again = (annealed_forest(near, roots, 1, deepest, seed, 20) for _ in range(2))
        assert owner == again
        assert max(depth_of_tree(near, owner, root) for root in roots) <= deepest
        assert max(map(owner.count, range(4))) <= max(map(paths.count, range(4)))


def test_a_search_cut_short_claims_nothing():
    """With few trials the bound is lower and the decision open, and neither is wrong."""
    network = skins("ring_12", 3, 72)
    near, roots = roots_and_neighbours(network, 0)
    deepest = int(least_depths(network).max()) + 4
    bounds = [least_load_within(near, roots, deepest, 90, trials) for trials in (0, 60, 300)]
    assert bounds == sorted(bounds)
    assert bounds[-1] <= 87
    decision = decide(near, roots, deepest, 86, 10)
    assert not decision.refuted
    assert decision.owner is None


def test_a_walled_in_cable_is_known():
    """On this skin of the set one cable's cell touches nothing but two cells before other cables' cells."""
    near, roots = near_and_roots(skins("cylinder", 5, 2))
    assert least_fullest(near, roots) == 82


def test_a_depth_for_even_loads_is_no_less_than_the_least(seed):
    for kind in ("sheet", "cylinder"):
        network = skins(kind, 3, seed % 100)
        hops = hops_to_cables(network)
        depth = least_depth_of_even_loads(hops, 66)
        assert depth >= hops.min(axis=0).max()
        assert least_depth_of_even_loads(hops, 65) is None
        assert least_depth_of_even_loads(hops, 198) == hops.min(axis=0).max()
