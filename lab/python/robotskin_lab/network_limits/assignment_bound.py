# SPDX-License-Identifier: Apache-2.0
"""Which cells the trees of a depth and load can hold at all, and which they must: a relaxation of every forest.

In a forest no deeper than D hops each cell belongs to one tree, whose root it reaches in D hops through cells of that
tree alone. Forget all but this, and cells are dealt to trees within reach, at most `load` to each. Whether that is
possible is Hall's condition: no set of trees alone reaches more cells than it can hold. Where a set reaches just as
many alone, it holds no others. A cell that one tree alone reaches is kept for it, and so is every cell without which
the tree could not reach a kept one; what is kept for one tree is closed to the others, which may put more out of their
reach. All this holds for all forests: where the deal fails no forest is possible, and where each cell is left to one
tree the deal is a forest.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from itertools import combinations, pairwise

from robotskin.layout.network_limits.cell_sets import any_of, in_several, members, neighbour_sets, rings, set_of, union

EVERY_SET_UP_TO = 8
"""Trees of which all sets are held against Hall's condition; of more, sets of up to two, and of all but one."""


@dataclass(frozen=True)
class Deal:
    """reach: by tree, the cells that it may hold; kept: by tree, those that it holds in every forest that is left."""

    reach: tuple[int, ...]
    kept: tuple[int, ...]

    @cached_property
    def undecided(self) -> int:
        """Cells that several trees may hold."""
        return in_several(self.reach)

    @cached_property
    def freedom(self) -> int:
        """Cells that trees may hold, summed over the trees: it shrinks with whatever becomes known."""
        return sum(cells.bit_count() for cells in self.reach)

    def owner(self, count: int) -> list[int]:
        """The tree of each of `count` cells, where none is undecided."""
        owner = [0] * count
        for tree, cells in enumerate(self.reach):
            for cell in members(cells):
                owner[cell] = tree
        return owner


class Dealing:
    """Deals cells to trees no deeper than `deepest` hops, the cable included, of at most `load` cells each.

    near: neighbours of each cell; roots: the cell of each cable, all different. trials: deals settled so far.
    """

    def __init__(self, near: list[list[int]], roots: list[int], deepest: int, load: int) -> None:
        self.near, self.roots, self.deepest, self.load = neighbour_sets(near), roots, deepest, load
        self.cells = (1 << len(near)) - 1
        self.trees = range(len(roots))
        few = [size for size in self.trees if len(roots) <= EVERY_SET_UP_TO or size <= 2 or size == len(roots) - 1]
        self.sets = [
            (chosen, [tree for tree in self.trees if tree not in chosen])
            for size in few
            if size
            for chosen in combinations(self.trees, size)
        ]
        self.trials = 0

    def first(self) -> Deal | None:
        """What is known before anything is supposed; None if no forest is possible."""
        if len(self.near) > self.load * len(self.roots):
            return None
        others = self.cells & ~set_of(self.roots)
        return self.settled([others | 1 << root for root in self.roots], [1 << root for root in self.roots])

    def inside(self, deal: Deal, tree: int, cell: int) -> Deal | None:
        """What follows if a tree holds the cells of a set, mostly one; None if no forest is possible."""
        reach = [cells if other == tree else cells & ~cell for other, cells in enumerate(deal.reach)]
        return self.settled(reach, [cells | cell if other == tree else cells for other, cells in enumerate(deal.kept)])

    def outside(self, deal: Deal, tree: int, cell: int) -> Deal | None:
        """Likewise if the tree holds none of them."""
        reach = [cells & ~cell if other == tree else cells for other, cells in enumerate(deal.reach)]
        return self.settled(reach, list(deal.kept))

    def settled(self, reach: list[int], kept: list[int]) -> Deal | None:
        """All that follows from what trees may hold and must; None if no forest is possible. Changes its arguments."""
        self.trials += 1
        shrunk, stale = set(self.trees), set(self.trees)
        while shrunk or stale:
            while shrunk:
                for tree in shrunk:
                    reach[tree] = self.reached(tree, reach[tree])
                stale |= shrunk
                shrunk = set()
                for tree, cells in self.full(reach):
                    if cells is None:
                        return None
                    if reach[tree] & cells:
                        reach[tree] &= ~cells
                        shrunk.add(tree)
            several = in_several(reach)
            for tree in self.trees:
                alone = reach[tree] & ~several & ~kept[tree]
                if alone:
                    kept[tree] |= alone
                    stale.add(tree)
            if stale:
                tree = min(stale)
                stale.discard(tree)
                if kept[tree] & ~reach[tree]:
                    return None
                bearing = self.bearing(tree, reach[tree], kept[tree])
                kept[tree] |= bearing
                for other in self.trees:
                    if other != tree and reach[other] & bearing:
                        reach[other] &= ~bearing
                        shrunk.add(other)
        return Deal(tuple(reach), tuple(kept))

    def reached(self, tree: int, allowed: int) -> int:
        """The allowed cells within reach of a tree's root through allowed cells."""
        return union(rings(self.near, self.roots[tree], allowed, self.deepest))

    def full(self, reach: list[int]) -> list[tuple[int, int | None]]:
        """Hall's condition: trees that can hold no cells of a set, or None instead of the set where it fails."""
        found: list[tuple[int, int | None]] = []
        for chosen, others in self.sets:
            elsewhere = 0
            for tree in others:
                elsewhere |= reach[tree]
            alone, room = (self.cells & ~elsewhere).bit_count(), self.load * len(chosen)
            if alone > room:
                return [(chosen[0], None)]
            if alone == room:
                found += [(tree, elsewhere) for tree in chosen]
        if union(reach) != self.cells:
            return [(0, None)]
        return found

    def bearing(self, tree: int, allowed: int, kept: int) -> int:
        """Cells not kept, without which a tree does not reach one of its kept cells."""
        hops = rings(self.near, self.roots[tree], allowed, self.deepest)
        # Such a cell lies on every way to the kept one, so on any one way: only those of one way are tried.
        ways = above = 0
        for hop in range(len(hops) - 1, 0, -1):
            wanted = above | (hops[hop] & kept)
            above = 0
            for cell in members(wanted):
                nearer = self.near[cell] & hops[hop - 1]
                above |= any_of(nearer & above) or any_of(nearer & kept) or any_of(nearer)
            ways |= above
        found = 0
        for cell in members(self.sole_ways(hops) & ways & ~kept):
            if kept & ~self.reached(tree, allowed & ~(1 << cell)):
                found |= 1 << cell
        return found

    def sole_ways(self, hops: list[int]) -> int:
        """Cells of rings that are the only nearer neighbour of some cell: without any other, no cell gets farther."""
        found = 0
        for nearer, ring in pairwise(hops):
            for cell in members(ring):
                above = self.near[cell] & nearer
                if not above & (above - 1):
                    found |= above
        return found
