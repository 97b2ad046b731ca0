"""Runs of the simulated network on skins of the benchmark set, in two processes at once."""

from __future__ import annotations

import math
import multiprocessing
from collections.abc import Callable, Iterable, Iterator
from concurrent.futures import ProcessPoolExecutor
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from robotskin._core.world import NetworkOptions, NetworkTrial, Wiring
from robotskin.bench.network_set import skins
from robotskin.layout.cell_network import CellNetwork
from robotskin.layout.network_limits import least_depths

STEP_S = 0.01
QUIET_S = 0.25
"""Without a change of loads a network has settled."""
LONGEST_S = 1.5


def wiring_of(network: CellNetwork) -> Wiring:
    """As the simulated network takes it."""
    return Wiring(network.neighbours, network.id.tolist(), network.unit_descriptions())


def trial_of(network: CellNetwork, seed: int, **options: Any) -> NetworkTrial:
    """A measured run of a skin. options: attributes of `NetworkOptions`."""
    chosen = NetworkOptions()
    chosen.seed = seed + 1
    for name, value in options.items():
        setattr(chosen, name, value)
    return NetworkTrial(wiring_of(network), chosen)


def loads_of(network: CellNetwork, trial: NetworkTrial) -> list[int]:
    """(K,) cells on each cable, in the order of the network's cables."""
    by_unit = trial.report().port_loads
    units = sorted({(cable.section_unit, cable.unit) for cable in network.cables})
    return [int(by_unit[units.index((c.section_unit, c.unit))][c.port - 1]) for c in network.cables]


@dataclass(frozen=True)
class PartLoads:
    """A connected part of a skin. fullest: cells on its fullest cable; ideal: ceil(cells / cables)."""

    part: int
    cells: int
    cables: int
    fullest: int

    @property
    def ideal(self) -> int:
        """Cells on each cable if they were even."""
        return math.ceil(self.cells / self.cables)


@dataclass(frozen=True)
class Settled:
    """How a skin formed and settled.

    formation_ms: -1 if it never formed with every cell on a shortest path. formed, loads: (K,) cells on each cable when
    it had formed, and at the end. history: (seconds since power-on, cells on the fullest cable of any part).
    depth, least_depth: hops of the deepest cell at the end, and at the least.
    sent, lost: samples in the time after it settled.
    """

    kind: str
    ports: int
    seed: int
    formation_ms: float
    formed: tuple[int, ...]
    loads: tuple[int, ...]
    parts: tuple[PartLoads, ...]
    depth: int
    least_depth: int
    sent: int = 0
    lost: int = 0
    latency_mean_ms: float = 0.0
    latency_p99_ms: float = 0.0
    history: tuple[tuple[float, int], ...] = field(default=(), repr=False)

    def balanced_s(self, fullest: float) -> float:
        """Seconds from power-on until the fullest cable first had no more cells; the whole run if it never had."""
        return next((when for when, load in self.history if load <= fullest), self.history[-1][0])


def part_loads(network: CellNetwork, loads: Iterable[int]) -> tuple[PartLoads, ...]:
    """Of each connected part."""
    found = []
    loads = np.array(list(loads))
    part_of_cable = network.part[network.roots]
    for part, cells in enumerate(np.bincount(network.part)):
        mine = loads[part_of_cable == part]
        found.append(PartLoads(part, int(cells), len(mine), int(mine.max())))
    return tuple(found)


def settle(kind: str, ports: int, seed: int) -> Settled:
    """Run a skin of the set until its loads stay as they are."""
    return settle_network(skins(kind, ports, seed), kind, ports, seed)


def settle_network(network: CellNetwork, kind: str, ports: int, seed: int, serve_s: float = 0.0) -> Settled:
    """Run a skin until its loads stay as they are, or for 1.5 s; then for `serve_s` more, over which losses count."""
    trial = trial_of(network, seed)
    formed: tuple[int, ...] = ()
    history: list[tuple[float, int]] = []
    loads: list[int] = []
    changed_s = now_s = 0.0
    while now_s < LONGEST_S:
        # Fine steps while it forms, so that the first trees are seen before they are balanced.
        now_s += 0.001 if not formed else STEP_S
        trial.run_until(now_s)
        if not formed and trial.report().formation_ms < 0 and now_s < 0.1:
            continue
        new = loads_of(network, trial)
        formed = formed or tuple(new)
        if new != loads:
            loads, changed_s = new, now_s
        parts = part_loads(network, loads)
        history.append((now_s, max(part.fullest for part in parts)))
        even = all(part.fullest <= part.ideal for part in parts)
        if now_s - changed_s >= (0.05 if even else QUIET_S):
            break
    report = trial.report()
    served = (report.samples_sent, report.samples_lost)
    if serve_s:
        trial.run_until(now_s + serve_s)
        report = trial.report()
    return Settled(
        kind,
        ports,
        seed,
        report.formation_ms,
        formed,
        tuple(loads),
        part_loads(network, loads),
        report.depth_max,
        int(least_depths(network).max()),
        report.samples_sent - served[0],
        report.samples_lost - served[1],
        report.latency_mean_ms,
        report.latency_p99_ms,
        tuple(history),
    )


Progress = Callable[[str], None]


def spread(run: Callable[..., Any], jobs: Iterable[tuple], processes: int, tell: Progress, what: str) -> Iterator[Any]:
    """`run(*job)` for each job in `processes` processes, results in the order of the jobs, told about as they come."""
    listed = list(jobs)
    if processes < 2:
        for number, job in enumerate(listed):
            tell(f"{what} {number + 1}/{len(listed)}")
            yield run(*job)
        return
    context = multiprocessing.get_context("spawn")
    with ProcessPoolExecutor(processes, mp_context=context) as pool:
        results = pool.map(run, *zip(*listed, strict=True), chunksize=max(1, min(8, len(listed) // (4 * processes))))
        for number, result in enumerate(results):
            tell(f"{what} {number + 1}/{len(listed)}")
            yield result
