# SPDX-License-Identifier: Apache-2.0
"""What trees of a depth can do at the best, from both sides: a load that none undercuts, and the best forest found."""

from __future__ import annotations

from dataclasses import dataclass, replace

from robotskin.layout.network_limits.annealing import STEPS_PER_CELL, annealed_forest
from robotskin.layout.network_limits.trees import least_fullest
from robotskin_lab.network_limits.branch_and_bound import decide


@dataclass(frozen=True)
class LoadWithin:
    """least: cells that the fullest tree of no forest undercuts. owner: the tree of each cell in the best found."""

    least: int
    owner: list[int]

    @property
    def fullest(self) -> int:
        """Cells of the fullest tree found."""
        return max(self.owner.count(tree) for tree in set(self.owner))


def load_within(
    near: list[list[int]],
    roots: list[int],
    deepest: int,
    most: int,
    trials: int,
    enough: int = 0,
    steps_per_cell: int = STEPS_PER_CELL,
) -> LoadWithin:
    """The least load of the fullest cable within a depth, as far as it can be enclosed.

    Args:
        near: neighbours of each cell, all connected.
        roots: the cell of each cable, all different.
        deepest: hops of the deepest cell, the cable included; no less than shortest paths have.
        most: a load that is known to be possible; no more is asked for.
        trials: of each decision by branch and bound, at most.
        enough: a load below which none is asked for.
        steps_per_cell: of the search for a forest, at most.

    Raises:
        InputError: `deepest` is less than shortest paths have.
    """
    least = least_load_within(near, roots, deepest, most)
    first = annealed_forest(near, roots, max(least, enough), deepest, steps_per_cell=steps_per_cell)
    found = LoadWithin(least, first)
    top, sure = min(found.fullest, most), True
    while max(found.least, enough) < top:
        # A forest one cell better is asked for as long as that is decided, then what lies between.
        load = top - 1 if sure else (max(found.least, enough) + top) // 2
        decision = decide(near, roots, deepest, load, trials)
        if decision.refuted:
            found = replace(found, least=load + 1)
        elif decision.owner is not None:
            found = replace(found, owner=decision.owner)
            top = found.fullest
        else:
            top, sure = load, False
    return found


def least_load_within(near: list[list[int]], roots: list[int], deepest: int, most: int, trials: int = 0) -> int:
    """A load that the fullest cable of no forest within `deepest` hops undercuts.

    Args:
        near, roots, deepest, trials: as of `decide`; no trials are quick.
        most: a load that is known to be possible; the bound is no more than this.
    """
    low, high = min(least_fullest(near, roots), most), most
    while low < high:
        middle = (low + high) // 2
        if decide(near, roots, deepest, middle, trials).refuted:
            low = middle + 1
        else:
            high = middle
    return low


def least_depth_of_load(
    near: list[list[int]], roots: list[int], load: int, shallowest: int, trials: int = 0
) -> int | None:
    """A depth that no forest with at most `load` cells a cable undercuts; None if there is none at any depth.

    Args:
        near, roots, trials: as of `decide`.
        load: cells a cable.
        shallowest: hops of the deepest cell on shortest paths.
    """
    if load < least_fullest(near, roots):
        return None
    for deepest in range(shallowest, len(near) + 1):
        if not decide(near, roots, deepest, load, trials).refuted:
            return deepest
    return None
