# SPDX-License-Identifier: Apache-2.0
"""Whether any forest keeps to a depth and a load: branch and bound over what cells trees hold.

What bears most is supposed first: a cell without which a tree loses others, such as the end of a bridge between
patches. With a few of these settled the rest of a bridged skin follows by `dealing`, or is refuted. Where no cell
bears anything any more, trees are peeled from their tips.
"""

from __future__ import annotations

from dataclasses import dataclass

from robotskin.layout.network_limits.cell_sets import any_of, members, rings
from robotskin_lab.network_limits.assignment_bound import Deal, Dealing


@dataclass(frozen=True)
class Decision:
    """refuted: no forest is possible, for certain. owner: the tree of each cell of a forest, if one was found.

    Neither: it was not decided within the trials.
    """

    refuted: bool
    owner: list[int] | None = None


def decide(near: list[list[int]], roots: list[int], deepest: int, load: int, trials: int) -> Decision:
    """Decide whether there is a forest no deeper than `deepest` hops with at most `load` cells a tree.

    Args:
        near: neighbours of each cell.
        roots: the cell of each cable, all different.
        deepest: hops of the deepest cell, the cable included.
        load: cells a tree.
        trials: deals to settle, at most; 0 asks only for what follows without suppositions.
    """
    dealing = Dealing(near, roots, deepest, load)
    deal = dealing.first()
    if deal is None:
        return Decision(True)
    left = [deal]
    while left:
        if dealing.trials > trials:
            return Decision(False)
        deal = left.pop()
        if not deal.undecided:
            return Decision(False, deal.owner(len(near)))
        left += branches(dealing, deal, trials)
    return Decision(True)


def branches(dealing: Dealing, deal: Deal, trials: int) -> list[Deal]:
    """What a deal falls into, the more promising last; every forest that is left of the deal is left in one of them.

    Each cell that bears others is supposed inside a tree and outside. Where one of the two is impossible the other is
    known; of the rest, the cell is chosen whose two sides both leave least free (Applegate et al.'s strong branching).
    """
    again = True
    while again:
        again = False
        best: tuple[tuple[int, int], list[Deal]] = ((-1, -1), [])
        for tree in dealing.trees:
            hops = rings(dealing.near, dealing.roots[tree], deal.reach[tree], dealing.deepest)
            for cell in members(dealing.sole_ways(hops) & ~deal.kept[tree]):
                one, reach = 1 << cell, deal.reach[tree]
                if not reach & one & ~deal.kept[tree]:
                    continue
                if (reach & ~dealing.reached(tree, reach & ~one)).bit_count() < 2:
                    continue
                if dealing.trials > trials:
                    return [deal]
                sides = [dealing.outside(deal, tree, one), dealing.inside(deal, tree, one)]
                possible = [side for side in sides if side is not None]
                if not possible:
                    return []
                if len(possible) == 1:
                    deal, again = possible[0], True
                    continue
                less, more = sorted(deal.freedom - side.freedom for side in possible)
                if (less, more) > best[0]:
                    best = ((less, more), possible)
    if best[1]:
        return best[1]
    return peeled(dealing, deal) if deal.undecided else [deal]


def peeled(dealing: Dealing, deal: Deal) -> list[Deal]:
    """The deal without the farthest undecided cell in the tree that could hold most, after the deal with it."""
    undecided = deal.undecided
    tree = max(
        (tree for tree in dealing.trees if undecided & deal.reach[tree]), key=lambda k: deal.reach[k].bit_count()
    )
    hops = rings(dealing.near, dealing.roots[tree], deal.reach[tree], dealing.deepest)
    cell = any_of(next(ring & undecided for ring in reversed(hops) if ring & undecided))
    sides = [dealing.inside(deal, tree, cell), dealing.outside(deal, tree, cell)]
    return [side for side in sides if side is not None]
