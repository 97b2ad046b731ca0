# SPDX-License-Identifier: Apache-2.0
"""How even the cables become, how soon and how deep: skins of the set, formed and settled."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from statistics import mean, median

import numpy as np

from robotskin.layout.cell_network import CellNetwork
from robotskin.layout.network_limits import (
    best_forest,
    bottleneck,
    hops_to_cables,
    least_depth_of_even_loads,
)
from robotskin.layout.network_limits.trees import least_fullest, roots_and_neighbours
from robotskin_lab.bench.network_naive import first_arrival_fullest
from robotskin_lab.bench.network_runs import LONGEST_S, PartLoads, Settled, settle_network
from robotskin_lab.bench.network_set import BRIDGED, COMPACT, ROBOTS, skins
from robotskin_lab.network_limits import least_depth_of_load, least_load_within, load_within

SERVED_S = 0.2
"""After a compact skin of three cables has settled and its rate is free again, to count losses."""
EVEN, FAIR = 1.02, 1.10
"""Fullest cable over the ideal at which a skin counts as balanced, and beyond which it counts as a miss."""
EXTRA_HOPS = 4
"""Over the fewest possible of the skin's deepest cell that any cell may have for the sake of even loads."""
TRIED_CELLS, COMPACT_TRIED_CELLS = 1_500_000, 300_000
"""Deals of each decision by branch and bound times cells, where a quick bound does not explain uneven loads. A compact
skin has no bridges that decide the rest: more deals find out nothing more about it."""
DEPTH_TRIED_CELLS = 150_000
"""Likewise of the depth that even loads need, asked for at one depth after the other."""


@dataclass(frozen=True)
class Balance:
    """A settled run beside what is possible.

    naive: cells of the fullest first-arrival tree (skins of one part). best: by part, the fullest cable of the best
    known forest of any depth; within: by part, cells that the fullest cable of no forest of the allowed depth
    undercuts (`best` itself where the network came to it); found: by part, those of the best forest of the allowed
    depth that is known; even_depth: a depth that no forest with the best loads undercuts; cut: cells a line at the
    minimum cut.
    """

    run: Settled
    naive: float
    best: tuple[int, ...]
    even_depth: int
    cut: float
    within: tuple[int, ...]
    found: tuple[int, ...]

    @property
    def fullest(self) -> int:
        """Cells on the fullest cable of any part."""
        return max(part.fullest for part in self.run.parts)

    @property
    def ratio(self) -> float:
        """Fullest cable over ceil(N / K), of a skin of one part."""
        return self.fullest / self.run.parts[0].ideal

    @property
    def proven(self) -> bool:
        """Whether no forest of the allowed depth has ceil(N / K) cells on its fullest cable, of a compact skin."""
        return self.within[0] > self.run.parts[0].ideal

    def ratios(self, least: int = 1) -> list[float]:
        """Fullest cable over best known, by part of more than `least` cells a cable."""
        return [
            part.fullest / best
            for part, best in zip(self.run.parts, self.best, strict=True)
            if part.cells > least * part.cables
        ]

    def ratios_to_possible(self) -> list[float]:
        """Likewise over the best known, or what is proven least within the allowed depth where that is more."""
        return [
            part.fullest / max(best, within)
            for part, best, within in zip(self.run.parts, self.best, self.within, strict=True)
            if part.cells > part.cables
        ]

    def time_s(self, ratio: float) -> float:
        """Seconds from power-on to this ratio, of a skin of one part; LONGEST_S if it never came there."""
        least = ratio * self.best[0]
        return self.run.balanced_s(least) if self.run.parts[0].fullest <= least else LONGEST_S

    def worst_part(self) -> PartLoads:
        """The part farthest from its best known."""
        return max(zip(self.run.parts, self.best, strict=True), key=lambda pair: pair[0].fullest / pair[1])[0]


def balance(kind: str, ports: int, seed: int) -> Balance:
    """Form and settle a skin of the set, and find what would have been possible."""
    network = skins(kind, ports, seed)
    compact = kind in COMPACT
    run = settle_network(network, kind, ports, seed, serve_s=SERVED_S if compact and ports == 3 else 0.0)
    hops = hops_to_cables(network)
    limits = []
    even_depth = 0
    for part in run.parts:
        cells, cables = np.flatnonzero(network.part == part.part), network.part[network.roots] == part.part
        own = hops[np.ix_(cables, cells)]
        depths = int(own.min(axis=0).max()), run.least_depth + EXTRA_HOPS
        limits.append(limits_of(network, part, depths, compact=compact))
        even_depth = max(even_depth, least_depth_of_even_loads(own, limits[-1].best) or 0, limits[-1].depth)
    naive = first_arrival_fullest(network, seed) if len(run.parts) == 1 else 0.0
    cut = float(bottleneck(network).cells_per_line)
    best, within, found = zip(*((one.best, one.within, one.found) for one in limits), strict=True)
    return Balance(run, naive, best, even_depth, cut, within, found)


@dataclass(frozen=True)
class Limits:
    """Of a part: `best`, `within` and `found` of `Balance`, and a depth that no forest with the best loads undercuts.

    The depth is 0 where none is asked for.
    """

    best: int
    within: int
    found: int
    depth: int = 0


def limits_of(network: CellNetwork, part: PartLoads, depths: tuple[int, int], compact: bool) -> Limits:
    """Branch and bound, and a search, only where the quick bound does not explain what the network left uneven.

    depths: the fewest possible hops of the part's deepest cell, and the allowed ones.
    """
    best = known_best(network, part, compact)
    if part.fullest <= best:
        return Limits(best, best, part.fullest)
    near, roots = roots_and_neighbours(network, part.part)
    least_depth, deepest = depths
    within, found = least_load_within(near, roots, deepest, part.fullest), part.fullest
    if part.fullest <= EVEN * best:
        return Limits(best, within, found)
    if part.fullest > EVEN * max(best, within):
        tried = COMPACT_TRIED_CELLS if compact else TRIED_CELLS
        limits = load_within(near, roots, deepest, part.fullest, tried // part.cells, best)
        within, found = limits.least, min(found, limits.fullest)
        best = min(best, found)
    trials = DEPTH_TRIED_CELLS // part.cells
    depth = least_depth_of_load(near, roots, best, least_depth, trials)
    if depth is None:
        best, depth = least_load_within(near, roots, len(near), part.fullest, trials), 0
    return Limits(best, max(best, within), found, depth)


def known_best(network: CellNetwork, part: PartLoads, compact: bool) -> int:
    """The fullest cable of the best known forest; of compact skins the bound itself, which is proven and no less.

    A network that comes to the bound needs no search.
    """
    near, roots = roots_and_neighbours(network, part.part)
    bound = least_fullest(near, roots)
    if compact or part.fullest <= bound:
        return bound
    forest = best_forest(network, part.part)
    return part.fullest if forest is None else min(forest.fullest, part.fullest)


def compact_figures(mine: list[Balance]) -> dict[str, float | int]:
    """Of compact skins with one number of cables."""
    ratios = [one.ratio for one in mine]
    to_possible = [max(one.ratios_to_possible()) for one in mine]
    missed = {name: [one for one in mine if one.ratio > ratio] for name, ratio in (("", FAIR), ("_102", EVEN))}
    extra = [one.run.depth - one.run.least_depth for one in mine]
    figures: dict[str, float | int] = {
        "balance_runs": len(mine),
        "balance_ratio_p95": float(np.quantile(ratios, 0.95)),
        "balance_ratio_max": max(ratios),
        "balance_ratio_to_possible_p95": float(np.quantile(to_possible, 0.95)),
        "balance_ratio_to_possible_max": max(to_possible),
        "balance_exact_share": mean(ratio <= 1 for ratio in ratios),
        "balance_time_p50_s": float(np.median([one.time_s(EVEN) for one in mine])),
        "balance_time_p95_s": float(np.quantile([one.time_s(EVEN) for one in mine], 0.95)),
        "extra_depth_mean": float(np.mean(extra)),
        "extra_depth_max": max(extra),
        "extra_depth_bound_mean": float(np.mean([one.even_depth - one.run.least_depth for one in mine])),
        "extra_depth_bound_max": max(one.even_depth - one.run.least_depth for one in mine),
        "load_gain_median": median(one.naive / one.run.parts[0].fullest - 1 for one in mine),
        "load_gain_min": min(one.naive / one.run.parts[0].fullest - 1 for one in mine),
        "load_gain_bound_median": median(one.naive / one.best[0] - 1 for one in mine),
    }
    for name, those in missed.items():
        limit = EVEN if name else FAIR
        figures[f"balance_misses{name}"] = len(those)
        figures[f"balance_misses{name}_proven"] = sum(one.proven for one in those)
        figures[f"balance_misses{name}_unavoidable"] = sum(
            one.within[0] > limit * one.run.parts[0].ideal for one in those
        )
    return figures


def balance_figures(balances: list[Balance]) -> dict[str, float | int]:
    """The figures of the issue: of compact skins those of three cables, the others beside with their number of cables.

    Ratios are to ceil(N / K), of bridged skins and robots to the best known trees of any depth; those `to_possible` to
    what is proven to be the least of the allowed depth where that is more.
    """
    runs = [one.run for one in balances]
    large = [run for run in runs if run.kind == "robot_1260"]
    figures: dict[str, float | int] = {
        "set_runs": len(runs),
        "formation_max_ms": max(run.formation_ms for run in runs),
        "formation_depth_exact": int(min(run.formation_ms for run in runs) >= 0),
        "named_max_ms": max(run.named_ms for run in runs),
    }
    if large:
        figures["formation_1260_ms"] = max(run.formation_ms for run in large)
        figures["named_1260_ms"] = max(run.named_ms for run in large)
    compact = [one for one in balances if one.run.kind in COMPACT]
    figures |= by_cables(compact, compact_figures)
    if compact:
        figures["balance_walled_in"] = sum(one.best[0] > one.run.parts[0].ideal for one in compact)
    for name, kinds in (("bridged", BRIDGED), ("robots", ROBOTS)):
        mine = [one for one in balances if one.run.kind in kinds]
        figures |= {f"{name}_{key}": value for key, value in by_cables(mine, figures_of_parts).items()}
    return figures


def by_cables(
    balances: list[Balance], figures_of: Callable[[list[Balance]], dict[str, float | int]]
) -> dict[str, float | int]:
    """Figures of each number of cables: first of three, the others with the number at the end of their keys."""
    figures: dict[str, float | int] = {}
    for ports in sorted({one.run.ports for one in balances}, key=lambda ports: ports != 3):
        for key, value in figures_of([one for one in balances if one.run.ports == ports]).items():
            figures[key if ports == 3 else f"{key}_k{ports}"] = value
    return figures


def figures_of_parts(balances: list[Balance]) -> dict[str, float | int]:
    """Of skins of bridged patches or of a robot, each by its worst part."""
    worst = [max(one.ratios(), default=1.0) for one in balances]
    to_possible = [max(one.ratios_to_possible(), default=1.0) for one in balances]
    return {
        "runs": len(balances),
        "ratio_p95": float(np.quantile(worst, 0.95)),
        "ratio_max": max(worst),
        "ratio_to_possible_max": max(to_possible),
        "misses": sum(ratio > FAIR for ratio in worst),
        "misses_to_possible": sum(ratio > FAIR for ratio in to_possible),
        "extra_depth_max": max(one.run.depth - one.run.least_depth for one in balances),
        "min_cut_cells_per_line_max": max(one.cut for one in balances),
    }
