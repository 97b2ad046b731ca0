# SPDX-License-Identifier: Apache-2.0
"""The rate at which every cell can be heard, whatever the routing: the maximum flow and the minimum cut.

Each line (a link in one direction, or a cable) carries C frames a second. If every one of N cells sends f frames a
second, all of them arrive by some routing exactly if no set S of cells sends more than the lines that leave it carry
(max-flow min-cut, Ford and Fulkerson 1956):

    f = C min over S of (links leaving S + cables of S) / |S|

The minimum is found exactly by Newton's method on the parametric flow (Dinkelbach 1967): a minimum cut for one f names
a set that does not carry it; f falls to what that set carries, until there is no such set.
"""

from __future__ import annotations

from dataclasses import dataclass
from fractions import Fraction

import numpy as np
from numpy.typing import NDArray
from scipy.sparse import csr_matrix
from scipy.sparse.csgraph import breadth_first_order, maximum_flow

from robotskin import firmware
from robotskin.layout.cell_network import CellNetwork

Integers = NDArray[np.int64]

DESIGN_RATE_HZ = 250
LINE_FRAMES_PER_S: int = firmware.CELLS_PER_PORT * DESIGN_RATE_HZ
"""Sample frames a line is planned to carry: 66 cells at 250 Hz, 82.5 % of the wire; the rest is control and reserve."""


@dataclass(frozen=True, eq=False)
class Bottleneck:
    """The cells that share the fewest lines.

    cells: (M,) indices, ascending; links: (L, 4) as in `CellNetwork.links`, those that leave the cells;
    cables: (C,) indices into the network's cables, those that end at them.
    """

    cells: Integers
    links: Integers
    cables: Integers

    @property
    def lines(self) -> int:
        """Links and cables through which all frames of the cells must go."""
        return len(self.links) + len(self.cables)

    @property
    def cells_per_line(self) -> Fraction:
        """The least load that any routing can give to the fullest of the lines."""
        return Fraction(len(self.cells), self.lines)

    @property
    def rate_hz(self) -> float:
        """Frames per second that each cell can send; 0 for cells without any way out."""
        return LINE_FRAMES_PER_S * self.lines / len(self.cells)


def cut_of(network: CellNetwork, inside: NDArray[np.bool_]) -> Bottleneck:
    """The lines that leave a set of cells. inside: (N,)."""
    crossing = inside[network.links[:, 0]] != inside[network.links[:, 2]]
    cables = np.flatnonzero(inside[network.roots]) if len(network.roots) else np.zeros(0, dtype=np.int64)
    return Bottleneck(np.flatnonzero(inside), network.links[crossing], cables)


def bottleneck(network: CellNetwork, part: int | None = None) -> Bottleneck:
    """The cut that limits the rate of a connected part, or of the whole skin: the least rate of its parts.

    Args:
        network: which cell is wired to which.
        part: which of its connected parts; all by default.
    """
    if part is None:
        cuts = [bottleneck(network, number) for number in range(int(network.part.max()) + 1)]
        return min(cuts, key=lambda cut: Fraction(cut.lines, len(cut.cells)))
    cells = np.flatnonzero(network.part == part)
    cut = cut_of(network, network.part == part)
    while cut.lines:
        within = carried(network, cells, cut.lines, len(cut.cells))
        if within is None:
            return cut
        cut = cut_of(network, within)
    return cut


def carried(network: CellNetwork, cells: Integers, frames: int, capacity: int) -> NDArray[np.bool_] | None:
    """Whether `cells`, a connected part, can send `frames` each over lines that carry `capacity`.

    Returns:
        None if they can, else (N,) a set of cells that sends more than its lines carry.
    """
    count = len(cells)
    place = np.full(len(network), -1)
    place[cells] = np.arange(count)
    source, sink = count, count + 1
    links = network.links[place[network.links[:, 0]] >= 0]
    first, second = place[links[:, 0]], place[links[:, 2]]
    roots = place[network.roots][place[network.roots] >= 0]
    rows = np.concatenate([first, second, np.full(count, source), roots])
    columns = np.concatenate([second, first, np.arange(count), np.full(len(roots), sink)])
    sizes = np.concatenate(
        [np.full(2 * len(links), capacity), np.full(count, frames), np.full(len(roots), capacity)]
    ).astype(np.int32)
    graph = csr_matrix((sizes, (rows, columns)), shape=(count + 2, count + 2))
    result = maximum_flow(graph, source, sink)
    if result.flow_value == frames * count:
        return None
    residual = csr_matrix(graph - result.flow)
    residual.eliminate_zeros()
    reached = breadth_first_order(residual, source, return_predecessors=False)
    within = np.zeros(len(network), dtype=bool)
    within[cells[reached[reached < count]]] = True
    return within
