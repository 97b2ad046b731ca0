# SPDX-License-Identifier: Apache-2.0
"""Good forests, of any depth or within one, by annealing: a cell changes trees with all that hangs on it alone."""

from __future__ import annotations

import math
from collections import deque
from random import Random

from robotskin.errors import InputError
from robotskin.layout.network_limits.cell_sets import members, neighbour_sets, rings, set_of, union

STEPS_PER_CELL = 1500
COOLINGS = 3
"""Each starts from where the one before ended."""
WARM, COLD = 3.0, 0.02
"""Temperatures, in cells: the energy is the mean over the cells of the load of their tree."""
PER_LATE_CELL = 0.7
"""Energy of a cell beyond the depth. Soft, so that trees may pass through what is not allowed."""


def annealed_forest(
    near: list[list[int]],
    roots: list[int],
    enough: int,
    deepest: int | None = None,
    seed: int = 0,
    steps_per_cell: int = STEPS_PER_CELL,
) -> list[int]:
    """The tree of each cell, in the forest with the least load that was found; the same seed gives the same.

    Args:
        near: neighbours of each cell, all connected.
        roots: the cell of each cable, all different.
        enough: load of the fullest tree at which the search ends.
        deepest: hops of the deepest cell, the cable included; no less than shortest paths have. Any if None.
        seed: of the search.
        steps_per_cell: of the search, at most.

    Raises:
        InputError: `deepest` is less than shortest paths have.
    """
    random, neighbours = Random(seed).random, neighbour_sets(near)
    owner = nearest_roots(near, roots)
    trees = [set_of([cell for cell in range(len(near)) if owner[cell] == tree]) for tree in range(len(roots))]
    least = max(len(rings(neighbours, root, cells, len(near))) for root, cells in zip(roots, trees, strict=True))
    deepest = len(near) if deepest is None else deepest
    if deepest < least:
        raise InputError(f"deepest: {deepest} hops: shortest paths have {least}, and no forest has fewer")

    def grown(tree: int, cells: int) -> tuple[int, float]:
        """The cells of a set that a root reaches, and their energy."""
        hops = rings(neighbours, roots[tree], cells, len(near))
        reached = union(hops)
        late = union(hops[deepest:]).bit_count()
        lates[tree] = late
        return reached, reached.bit_count() ** 2 / len(near) + PER_LATE_CELL * late

    lates = [0] * len(roots)
    energies = [grown(tree, cells)[1] for tree, cells in enumerate(trees)]
    best, fullest = list(owner), max(cells.bit_count() for cells in trees)
    free = [cell for cell in range(len(near)) if cell not in roots]
    steps = steps_per_cell * len(near) if free else 0
    for step in range(steps):
        if fullest <= enough:
            break
        cell = free[int(random() * len(free))]
        here, there = owner[cell], owner[near[cell][int(random() * len(near[cell]))]]
        if here == there:
            continue
        before = lates[here], lates[there]
        stay, energy_here = grown(here, trees[here] & ~(1 << cell))
        gone = trees[here] & ~stay
        more, energy_there = grown(there, trees[there] | gone)
        change = energy_here + energy_there - energies[here] - energies[there]
        temperature = WARM * (1 - COOLINGS * step / steps % 1.0) ** 2 + COLD
        if change > 0 and random() >= math.exp(-change / temperature):
            lates[here], lates[there] = before
            continue
        trees[here], trees[there] = stay, more
        energies[here], energies[there] = energy_here, energy_there
        for member in members(gone):
            owner[member] = there
        load = max(cells.bit_count() for cells in trees)
        if load < fullest and not any(lates):
            best, fullest = list(owner), load
    return best


def nearest_roots(near: list[list[int]], roots: list[int]) -> list[int]:
    """The tree of each cell, where each goes to a nearest root."""
    owner = [-1] * len(near)
    for tree, root in enumerate(roots):
        owner[root] = tree
    queue = deque(roots)
    while queue:
        cell = queue.popleft()
        for other in near[cell]:
            if owner[other] < 0:
                owner[other] = owner[cell]
                queue.append(other)
    return owner
