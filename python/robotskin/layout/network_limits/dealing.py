"""How even loads can become within a depth: a bound on every forest, by dealing cells to cables.

In a forest no deeper than D hops each cell belongs to one cable that it reaches in D hops through cells of that cable
alone. Forget all but this and cells are dealt to cables within reach, at most `load` to each: a maximum flow. Where
even that is impossible, no forest is possible. Suppositions make it sharper: if the deal fails once a cell is taken
from a tree, the cell is in that tree in every forest, and no other tree has a way through it; if it fails once the cell
is given to a tree, the cell is never in it. Every step holds for all forests, so the bound is a true one; as in the
other bounds, a cell with a cable sends by it.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from robotskin.layout.network_limits.depth import fits
from robotskin.layout.network_limits.trees import least_fullest

PASSES = 4
"""Of suppositions over all cells; each may use what the one before found out."""


class Dealing:
    """Cells that each tree can hold, no deeper than `deepest` hops and with at most `load` cells.

    near: neighbours of each cell; roots: the cell of each cable, all different.
    """

    def __init__(self, near: list[list[int]], roots: list[int], deepest: int, load: int) -> None:
        self.near, self.roots, self.deepest, self.load = near, roots, deepest, load
        self.closed = np.zeros((len(roots), len(near)), dtype=bool)
        self.closed[:, roots] = ~np.eye(len(roots), dtype=bool)
        self.reach = np.array([self.reached(tree) for tree in range(len(roots))])

    def reached(self, tree: int, without: int = -1) -> NDArray[np.bool_]:
        """(N,) cells within reach of a tree's cable through cells that may be in the tree; `without` may not."""
        seen = self.closed[tree].tolist()
        if without >= 0:
            seen[without] = True
        found = np.zeros(len(self.near), dtype=bool)
        ring, hops = [self.roots[tree]], 1
        seen[self.roots[tree]] = True
        while ring and hops <= self.deepest:
            found[ring] = True
            further = []
            for cell in ring:
                for other in self.near[cell]:
                    if not seen[other]:
                        seen[other] = True
                        further.append(other)
            ring, hops = further, hops + 1
        return found

    def possible(self, reach: NDArray[np.bool_] | None = None) -> bool:
        """Whether cells can be dealt to trees that reach them."""
        return fits(np.where(self.reach if reach is None else reach, 0.0, np.inf), 0.0, self.load)

    def close(self, tree: int, cell: int) -> None:
        """A cell is never in a tree."""
        self.closed[tree, cell] = True
        self.reach[tree] = self.reached(tree)

    def suppose(self, cell: int) -> bool:
        """Close a cell to the trees that it cannot be in; whether it was closed to any."""
        trees = [tree for tree in np.flatnonzero(self.reach[:, cell]).tolist() if self.roots[tree] != cell]
        if len(trees) < 2:
            return False
        without = {tree: self.reached(tree, cell) for tree in trees}
        # A cell on no tree's only way bears no supposition: the others stay within reach as they are.
        bears = [tree for tree in trees if self.reach[tree].sum() - without[tree].sum() > 1]
        for tree in trees:
            others = [other for other in trees if other != tree]
            if tree in bears:
                reach = self.reach.copy()
                reach[tree] = without[tree]
                if not self.possible(reach):
                    for other in others:
                        self.close(other, cell)
                    return True
            if set(bears) - {tree}:
                reach = self.reach.copy()
                reach[others] = [without[other] for other in others]
                if not self.possible(reach):
                    self.close(tree, cell)
                    return True
        return False

    def refuted(self, passes: int = PASSES) -> bool:
        """Whether no forest is possible: known for certain if True, unknown if False."""
        for _ in range(passes):
            if not self.possible():
                return True
            if not any([self.suppose(cell) for cell in range(len(self.near))]):
                return False
        return not self.possible()


def least_load_within(near: list[list[int]], roots: list[int], deepest: int, most: int, passes: int = 0) -> int:
    """A load that the fullest cable of no forest within `deepest` hops undercuts.

    Args:
        near: neighbours of each cell.
        roots: the cell of each cable, all different.
        deepest: hops of the deepest cell, the cable included.
        most: a load that is known to be possible; the bound is no more than this.
        passes: of suppositions, at most; none are quick.
    """
    low, high = min(least_fullest(near, roots), most), most
    while low < high:
        middle = (low + high) // 2
        if Dealing(near, roots, deepest, middle).refuted(passes):
            low = middle + 1
        else:
            high = middle
    return low


def least_depth_of_load(
    near: list[list[int]], roots: list[int], load: int, shallowest: int, passes: int = 0
) -> int | None:
    """A depth that no forest with at most `load` cells a cable undercuts; None if there is none at any depth.

    Args:
        near, roots, passes: as of `least_load_within`.
        load: cells a cable.
        shallowest: hops of the deepest cell on shortest paths.
    """
    if load < least_fullest(near, roots):
        return None
    for deepest in range(shallowest, len(near) + 1):
        if not Dealing(near, roots, deepest, load).refuted(passes):
            return deepest
    return None
