# SPDX-License-Identifier: Apache-2.0
"""What a skin's wiring can carry, for those who design it: each connected part judged, and the tightest place named."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

from robotskin.layout.cell_network import CellNetwork
from robotskin.layout.network_limits.advice import Advice, best_bridge, best_cable
from robotskin.layout.network_limits.depth import hops_to_cables, least_depth_of_even_loads
from robotskin.layout.network_limits.flow import DESIGN_RATE_HZ, LINE_FRAMES_PER_S, Bottleneck, bottleneck
from robotskin.layout.network_limits.trees import Forest, best_forest


@dataclass(frozen=True, eq=False)
class PartVerdict:
    """A connected part of the skin.

    cut: the minimum cut that limits it; forest: its best trees, None without a cable; depth: hops of its deepest cell
    on the shortest path, even_depth: at least so many if the cables are as even as in the forest (None: no cable).
    """

    cells: int
    patches: tuple[str, ...]
    cables: int
    cut: Bottleneck
    forest: Forest | None
    depth: int | None
    even_depth: int | None

    @property
    def any_rate_hz(self) -> float:
        """At which every cell can be heard if frames may be split over every path."""
        return self.cut.rate_hz

    @property
    def tree_rate_hz(self) -> float:
        """At which every cell can be heard with one parent a cell."""
        return LINE_FRAMES_PER_S / self.forest.fullest if self.forest else 0.0


@dataclass(frozen=True, eq=False)
class Verdict:
    """A skin. parts: the tightest first; cable, bridge: the one more that would help the tightest most, if any."""

    network: CellNetwork
    rate_hz: float
    parts: tuple[PartVerdict, ...]
    cable: Advice | None
    bridge: Advice | None

    @property
    def cells_per_line(self) -> int:
        """Cells that one cable or link carries at the rate asked for."""
        return int(LINE_FRAMES_PER_S / self.rate_hz)

    @property
    def any_rate_hz(self) -> float:
        """Of the whole skin, by any routing."""
        return self.parts[0].any_rate_hz

    @property
    def tree_rate_hz(self) -> float:
        """Of the whole skin, by trees."""
        return min(part.tree_rate_hz for part in self.parts)

    def as_json(self) -> dict[str, Any]:
        """Plain values."""
        return {
            "name": self.network.name,
            "cells": len(self.network),
            "cables": len(self.network.cables),
            "rate_hz": self.rate_hz,
            "cells_per_line": self.cells_per_line,
            "any_rate_hz": self.any_rate_hz,
            "tree_rate_hz": self.tree_rate_hz,
            "parts": [
                {
                    "cells": part.cells,
                    "patches": list(part.patches),
                    "cables": part.cables,
                    "any_rate_hz": part.any_rate_hz,
                    "tree_rate_hz": part.tree_rate_hz,
                    "loads": part.forest.loads.tolist() if part.forest else [],
                    "least_fullest": part.forest.bound if part.forest else None,
                    "depth": part.depth,
                    "even_depth": part.even_depth,
                    "cut_cells": part.cut.cells.tolist(),
                    "cut_links": part.cut.links.tolist(),
                    "cut_cables": part.cut.cables.tolist(),
                }
                for part in self.parts
            ],
            "one_more_cable": advice_json(self.cable),
            "one_more_bridge": advice_json(self.bridge),
        }


def advice_json(advice: Advice | None) -> dict[str, Any] | None:
    """Plain values."""
    if advice is None:
        return None
    return {"ends": [list(end) for end in advice.ends], "rate_hz": advice.rate_hz, "distance_m": advice.distance_m}


def judge(network: CellNetwork, rate_hz: float = DESIGN_RATE_HZ, seed: int = 0) -> Verdict:
    """Judge a skin's wiring.

    Args:
        network: of at least one cell.
        rate_hz: of every cell, that the skin shall reach.
        seed: of the search for trees.
    """
    hops = hops_to_cables(network)
    parts = [judge_part(network, number, hops, seed) for number in range(int(network.part.max()) + 1)]
    parts.sort(key=lambda part: (part.any_rate_hz, part.tree_rate_hz, -part.cells))
    tightest = parts[0].cut
    return Verdict(network, rate_hz, tuple(parts), best_cable(network, tightest), best_bridge(network, tightest))


def judge_part(network: CellNetwork, number: int, hops: np.ndarray, seed: int) -> PartVerdict:
    """Judge one connected part. hops: (K, N) as `hops_to_cables` gives them."""
    cells = np.flatnonzero(network.part == number)
    cables = np.flatnonzero(network.part[network.roots] == number)
    forest = best_forest(network, number, seed)
    own = hops[np.ix_(cables, cells)]
    return PartVerdict(
        len(cells),
        tuple(dict.fromkeys(network.patch_name(int(cell)) for cell in cells)),
        len(cables),
        bottleneck(network, number),
        forest,
        int(own.min(axis=0).max()) if len(cables) else None,
        least_depth_of_even_loads(own, forest.fullest) if forest else None,
    )
