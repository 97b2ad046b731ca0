# SPDX-License-Identifier: Apache-2.0
"""Where one more cable, or one more bridge between patches, raises the rate of a skin most."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from robotskin.layout.cell_network import CellNetwork
from robotskin.layout.network_limits.depth import least_depths
from robotskin.layout.network_limits.flow import Bottleneck, bottleneck

Integers = NDArray[np.int64]

CABLE_TRIALS = 24
BRIDGE_TRIALS = 60
GAIN_WORTH_TELLING = 1.005


@dataclass(frozen=True)
class Advice:
    """ends: (cell, port) of the cable, or of both ends of the bridge; rate_hz: of the cells behind the cut, after.

    distance_m: between the ends of a bridge on one link; None across links.
    """

    ends: tuple[tuple[int, int], ...]
    rate_hz: float
    distance_m: float | None = None


def best_cable(network: CellNetwork, cut: Bottleneck) -> Advice | None:
    """The free port at which one more cable helps the cells behind `cut` most; among equals that of the least depth.

    A cable elsewhere cannot help them: their lines stay as few. Up to 24 places are tried, spread over the patches.
    """
    free = network.free_ports
    open_cells = cut.cells[free[cut.cells].any(axis=1)]
    best, best_key = None, (cut.rate_hz * GAIN_WORTH_TELLING, 0.0, 0.0)
    for cell in spread(network, open_cells, CABLE_TRIALS):
        port = int(np.flatnonzero(free[cell])[0]) + 1
        trial = network.with_cable(int(cell), port)
        depths = least_depths(trial)[cut.cells]
        rate = bottleneck(trial, int(trial.part[cell])).rate_hz
        key = (rate, -float(depths.max()), -float(depths.mean()))
        if key > best_key:
            best, best_key = Advice(((int(cell), port),), rate), key
    return best


def best_bridge(network: CellNetwork, cut: Bottleneck) -> Advice | None:
    """The link between two free ports that helps the cells behind `cut` most; among equals the shortest.

    It must lead out of the cut, to cells of the same section-unit group (one name space of ids). The nearest free ports
    of each pair of patches are looked at, the 60 most promising pairs tried.
    """
    free = network.free_ports.any(axis=1)
    inside = np.zeros(len(network), dtype=bool)
    inside[cut.cells] = True
    group = network.group[cut.cells[0]]
    here = patches_of(network, np.flatnonzero(inside & free))
    there = patches_of(network, np.flatnonzero(~inside & free & (network.group == group)))
    parts = np.bincount(network.part)
    cables = np.bincount(network.part[network.roots], minlength=len(parts))
    candidates = []
    for inner in here:
        for outer in there:
            first, second, distance = nearest(network, inner, outer)
            one, other = network.part[first], network.part[second]
            most = np.inf if one == other else (cables[one] + cables[other]) / (parts[one] + parts[other])
            candidates.append((-most, distance, first, second))
    best, best_key = None, (cut.rate_hz * GAIN_WORTH_TELLING, 0.0)
    for _, distance, first, second in sorted(candidates)[:BRIDGE_TRIALS]:
        ports = [int(np.flatnonzero(network.free_ports[cell])[0]) + 1 for cell in (first, second)]
        trial = network.with_bridge(first, ports[0], second, ports[1])
        rate = bottleneck(trial, int(trial.part[first])).rate_hz
        key = (rate, -distance)
        if key > best_key:
            length = None if np.isinf(distance) else float(distance)
            best, best_key = Advice(((first, ports[0]), (second, ports[1])), rate, length), key
    return best


def spread(network: CellNetwork, cells: Integers, count: int) -> Integers:
    """Up to `count` of the cells, of every patch in turn, evenly over each patch's list."""
    if len(cells) <= count:
        return cells
    by_patch = patches_of(network, cells)
    each = max(1, count // len(by_patch))
    chosen = [patch[np.unique(np.linspace(0, len(patch) - 1, each).astype(int))] for patch in by_patch]
    return np.concatenate(chosen)


def patches_of(network: CellNetwork, cells: Integers) -> list[Integers]:
    """The cells of each patch."""
    return [cells[network.patch[cells] == patch] for patch in np.unique(network.patch[cells])]


def nearest(network: CellNetwork, cells: Integers, others: Integers) -> tuple[int, int, float]:
    """The pair of cells with the least distance in metres; on different links the first of each, infinitely far."""
    if network.link[cells[0]] != network.link[others[0]]:
        return int(cells[0]), int(others[0]), float("inf")
    apart = np.linalg.norm(network.position_m[cells][:, None] - network.position_m[others][None], axis=2)
    one, other = np.unravel_index(np.argmin(apart), apart.shape)
    return int(cells[one]), int(others[other]), float(apart[one, other])
