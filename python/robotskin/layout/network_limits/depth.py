# SPDX-License-Identifier: Apache-2.0
"""How many hops a frame needs: at the least, and if the cables are to share the cells evenly."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray
from scipy.sparse import csr_matrix
from scipy.sparse.csgraph import dijkstra, maximum_flow

from robotskin.layout.cell_network import CellNetwork

Integers = NDArray[np.int64]


def hops_to_cables(network: CellNetwork) -> NDArray[np.float64]:
    """(K, N) hops from each cell to the section unit by each cable, the cable itself included; inf without a path."""
    count = len(network)
    ends = np.ones(len(network.links))
    graph = csr_matrix((ends, (network.links[:, 0], network.links[:, 2])), shape=(count, count))
    if not len(network.roots):
        return np.full((1, count), np.inf)
    return dijkstra(graph, directed=False, unweighted=True, indices=network.roots) + 1


def least_depths(network: CellNetwork) -> NDArray[np.float64]:
    """(N,) hops of each cell's shortest path to any cable; inf where there is none."""
    return np.asarray(hops_to_cables(network).min(axis=0))


def fits(hops: NDArray[np.float64], deepest: float, load: int) -> bool:
    """Whether cells can be dealt to cables no farther than `deepest` hops with at most `load` each (b-matching)."""
    cables, count = hops.shape
    cable, cell = np.nonzero(hops <= deepest)
    source, sink = count + cables, count + cables + 1
    rows = np.concatenate([cell, np.full(count, source), count + np.arange(cables)])
    columns = np.concatenate([count + cable, np.arange(count), np.full(cables, sink)])
    sizes = np.concatenate([np.ones(len(cell) + count), np.full(cables, load)]).astype(np.int32)
    graph = csr_matrix((sizes, (rows, columns)), shape=(sink + 1, sink + 1))
    return bool(maximum_flow(graph, source, sink).flow_value == count)


def least_depth_of_even_loads(hops: NDArray[np.float64], load: int) -> int | None:
    """A depth that no forest with at most `load` cells a cable can undercut; None if there is none at all.

    It is a bound: cells are dealt to cables within reach, whether or not the others on their way go the same way.

    Args:
        hops: (K, N) of one connected part, as `hops_to_cables` gives them.
        load: cells a cable.
    """
    low, high = int(hops.min(axis=0).max()), int(hops.max())
    if not fits(hops, high, load):
        return None
    while low < high:
        middle = (low + high) // 2
        if fits(hops, middle, load):
            high = middle
        else:
            low = middle + 1
    return low
