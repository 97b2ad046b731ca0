# SPDX-License-Identifier: Apache-2.0
"""The plain store-and-forward network of the speed comparison, written as a user of SimPy would write it.

Every cell of a tree sends a frame each period, at a phase of its own. A cell forwards what it has sampled or received
to its parent: one process a cell takes frames from a queue and holds each for the time it needs on the wire. Nothing
else happens, in SimPy or in our world, so that what is compared is the clockwork alone.
"""

from __future__ import annotations

import time
from collections.abc import Generator, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from robotskin import firmware
from robotskin.layout.cell_network import CellNetwork
from robotskin.layout.network_limits import hops_to_cables
from robotskin_lab._lab.baselines import run_plain_network

FRAME_US: int = firmware.FRAME_US


@dataclass(frozen=True)
class PlainRun:
    """hops: frames that a wire has delivered; wall_s: that it took."""

    hops: int
    wall_s: float

    @property
    def hops_per_s(self) -> float:
        """Speed."""
        return self.hops / self.wall_s


def shortest_path_parents(network: CellNetwork) -> list[int]:
    """(N,) the parent of each cell on a shortest path to a cable, -1 for cells with a cable."""
    depth = hops_to_cables(network).min(axis=0)
    parents = []
    for cell, neighbours in enumerate(network.neighbours[:, :, 0]):
        nearer = [int(other) for other in neighbours if other >= 0 and depth[other] < depth[cell]]
        parents.append(nearer[0] if depth[cell] > 1 else -1)
    return parents


def run_simpy(parents: Sequence[int], seconds: float, rate_hz: float = 250.0) -> PlainRun:
    """Frames of all cells over `seconds` of simulated time, by SimPy."""
    import simpy

    environment = simpy.Environment()
    queues = [simpy.Store(environment) for _ in parents]
    period_us = 1e6 / rate_hz
    hops = 0

    def sample(cell: int) -> Generator[Any, Any, None]:
        yield environment.timeout(period_us * cell / len(parents))
        while True:
            yield queues[cell].put(cell)
            yield environment.timeout(period_us)

    def forward(cell: int, parent: int) -> Generator[Any, Any, None]:
        nonlocal hops
        while True:
            frame = yield queues[cell].get()
            yield environment.timeout(FRAME_US)
            hops += 1
            if parent >= 0:
                yield queues[parent].put(frame)

    for cell, parent in enumerate(parents):
        environment.process(sample(cell))
        environment.process(forward(cell, parent))
    start = time.perf_counter()
    environment.run(until=1e6 * seconds)
    return PlainRun(hops, time.perf_counter() - start)


def run_plain(parents: Sequence[int], seconds: float, rate_hz: float = 250.0) -> PlainRun:
    """The same by the clockwork of our world."""
    start = time.perf_counter()
    counts = run_plain_network(list(parents), 1 / rate_hz, seconds)
    return PlainRun(counts.hops, time.perf_counter() - start)


def expected_hops(network: CellNetwork, seconds: float, rate_hz: float = 250.0) -> float:
    """Hops of all frames that cells send in that time: one a hop of each cell's depth."""
    return float(np.sum(hops_to_cables(network).min(axis=0)) * seconds * rate_hz)
