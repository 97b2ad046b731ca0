# SPDX-License-Identifier: Apache-2.0
"""How large a skin may grow: a cylinder lengthened row by row until a cable has too many cells."""

from __future__ import annotations

from dataclasses import dataclass
from statistics import median

from robotskin import firmware
from robotskin_lab.bench.network_naive import AROUND, cylinder, most_rows, naive_rows
from robotskin_lab.bench.network_runs import settle_network
from robotskin_lab.bench.network_set import PORTS


@dataclass(frozen=True)
class Growth:
    """Cells of the longest cylinder: by first-arrival trees, by the network, by any routing."""

    ports: int
    placement: str
    seed: int
    naive: int
    ours: int
    most: int

    @property
    def gain(self) -> float:
        """Over first-arrival trees."""
        return self.ours / self.naive - 1

    @property
    def bound(self) -> float:
        """The gain of any routing."""
        return self.most / self.naive - 1


def grow(ports: int, placement: str, seed: int) -> Growth:
    """The largest cylinders of one placement of the cables.

    The network is tried from the longest that any routing serves downwards, so that a length that it serves is the
    longest that it serves.
    """
    naive, most = naive_rows(ports, placement, seed), most_rows(ports, placement, seed)
    ours = most
    while ours > 1:
        settled = settle_network(cylinder(ours, ports, placement, seed), "growing", ports, seed)
        if max(settled.loads) <= firmware.CELLS_PER_PORT:
            break
        ours -= 1
    return Growth(ports, placement, seed, AROUND * naive, AROUND * ours, AROUND * most)


def size_figures(growths: list[Growth]) -> dict[str, float]:
    """Gains in the middle for each number of cables, beside the bound, and the least of all."""
    figures: dict[str, float] = {"size_gain_min": min(growth.gain for growth in growths)}
    ratios = []
    for ports in PORTS:
        mine = [growth for growth in growths if growth.ports == ports]
        if not mine:
            continue
        gain, bound = median(growth.gain for growth in mine), median(growth.bound for growth in mine)
        figures[f"size_gain_median_k{ports}"] = gain
        figures[f"size_gain_bound_median_k{ports}"] = bound
        ratios.append(gain / bound if bound > 0 else 1.0)
        if ports == 3:
            figures["size_gain_median"] = gain
            figures["size_gain_bound_median"] = bound
    figures["size_gain_of_bound_min"] = min(ratios)
    return figures
