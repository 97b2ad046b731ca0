# SPDX-License-Identifier: Apache-2.0
"""Runs of the simulated network on skins of the benchmark set, wherever an executor runs them."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable, Iterator
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from robotskin.keys import SkinKeys
from robotskin.layout.cell_network import CellNetwork
from robotskin.layout.network_limits import least_depths
from robotskin.simulator import NetworkOptions, NetworkTrial, TrialReport, Wiring
from robotskin.world.ideal import default_processor
from robotskin_lab.bench.network_set import skins
from robotskin_lab.executors import Executor, in_order

STEP_S = 0.01
RATE_HZ = 250
RELEASE_S = 0.6
"""After overload, section units thin out samples a while longer; then every cell sends at its full rate again."""
EVEN_S = 0.05
QUIET_S = 0.5
"""Without a change of loads for so long, even loads or others, a network has settled: cells at the border let go of
their branches by turns, and a quarter of a second passes until each has had its turn."""
LONGEST_S = 2.0
LATENCY_STEP_MS = 0.01


def wiring_of(network: CellNetwork) -> Wiring:
    """As the simulated network takes it."""
    return Wiring(network.neighbours, network.id.tolist(), network.unit_descriptions())


def trial_of(network: CellNetwork, seed: int, **options: Any) -> NetworkTrial:
    """A measured run of a skin. options: attributes of `NetworkOptions`."""
    chosen = NetworkOptions()
    chosen.seed = seed + 1
    chosen.processor = default_processor()
    chosen.set_cell_key(SkinKeys.of_seed(seed).cell_key)
    for name, value in options.items():
        setattr(chosen, name, value)
    return NetworkTrial(wiring_of(network), chosen)


def loads_of(network: CellNetwork, trial: NetworkTrial) -> list[int]:
    """(K,) cells on each cable, in the order of the network's cables."""
    by_unit = trial.report().port_loads
    units = sorted({(cable.group, cable.unit) for cable in network.cables})
    return [int(by_unit[units.index((c.group, c.unit))][c.port - 1]) for c in network.cables]


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
class Service:
    """What the host got over a time. sent, lost: samples; missing: share of 250 Hz from every cell that was not heard;
    latency_counts: samples by latency, each count of `LATENCY_STEP_MS` more.

    What is missing was lost, or thinned out by the rate divisor because a cable had too many cells.
    """

    sent: int
    lost: int
    missing: float
    latency_mean_ms: float
    latency_p99_ms: float
    latency_counts: tuple[int, ...] = field(repr=False)

    @classmethod
    def of(cls, report: TrialReport, cells: int, seconds: float) -> Service:
        """From a report that was begun anew `seconds` ago. The samples still on their way are no loss."""
        missing = max(0.0, 1 - (report.samples_heard + 0.001 * RATE_HZ * cells) / (RATE_HZ * cells * seconds))
        return cls(
            report.samples_sent,
            report.samples_lost,
            missing,
            report.latency_mean_ms,
            report.latency_p99_ms,
            tuple(report.latency_counts),
        )


def latency_quantile_ms(services: Iterable[Service], share: float) -> float:
    """The latency that this share of all samples of several runs kept."""
    counts = np.sum([served.latency_counts for served in services], axis=0).cumsum()
    return LATENCY_STEP_MS * float(np.searchsorted(counts, share * counts[-1]) + 1)


@dataclass(frozen=True)
class Settled:
    """How a skin formed and settled.

    formation_ms: until every cell was on a shortest path, named_ms: and had an id; -1: never. formed, loads: (K,) cells
    on each cable when it had formed, and at the end. history: (seconds since power-on, cells on the fullest cable of
    any part).
    depth, least_depth: hops of the deepest cell at the end, and at the least.
    service: what the host got after that, if that was looked at.
    """

    kind: str
    ports: int
    seed: int
    formation_ms: float
    named_ms: float
    formed: tuple[int, ...]
    loads: tuple[int, ...]
    parts: tuple[PartLoads, ...]
    depth: int
    least_depth: int
    service: Service | None
    history: tuple[tuple[float, int], ...] = field(repr=False)

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


NAIVE_FROM_S, NAIVE_TO_S = 0.035, 0.085
"""When every cell has an id, and before the section units grant the first move."""


def naive_service(kind: str, ports: int, seed: int) -> Service:
    """What the host gets over trees of the first arrival: the same run, before the first move of balance."""
    network = skins(kind, ports, seed)
    trial = trial_of(network, seed)
    trial.run_until(NAIVE_FROM_S)
    trial.measure_anew()
    trial.run_until(NAIVE_TO_S)
    return Service.of(trial.report(), len(network), NAIVE_TO_S - NAIVE_FROM_S)


def settle(kind: str, ports: int, seed: int) -> Settled:
    """Run a skin of the set until its loads stay as they are."""
    return settle_network(skins(kind, ports, seed), kind, ports, seed)


def run_to_balance(network: CellNetwork, trial: NetworkTrial) -> tuple[tuple[int, ...], tuple[tuple[float, int], ...]]:
    """Run until the loads are even or stay as they are, for 1.5 s at most.

    Returns:
        (K,) loads of the first trees, and (seconds since power-on, cells on the fullest cable of any part) over time.
    """
    formed: tuple[int, ...] = ()
    history: list[tuple[float, int]] = []
    loads: list[int] = []
    changed_s = now_s = 0.0
    while now_s < LONGEST_S:
        # Fine steps while it forms, so that the first trees are seen before they are balanced.
        now_s += STEP_S if formed else 0.001
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
        if now_s - changed_s >= (EVEN_S if even else QUIET_S):
            break
    return formed, tuple(history)


def settle_network(network: CellNetwork, kind: str, ports: int, seed: int, serve_s: float = 0.0) -> Settled:
    """Run a skin until its loads stay as they are, or for 1.5 s; then for `serve_s` more, over which losses count."""
    trial = trial_of(network, seed)
    formed, history = run_to_balance(network, trial)
    loads = loads_of(network, trial)
    if serve_s:
        trial.run_until(history[-1][0] + RELEASE_S)
        trial.measure_anew()
        trial.run_until(history[-1][0] + RELEASE_S + serve_s)
    report = trial.report()
    return Settled(
        kind,
        ports,
        seed,
        report.formation_ms,
        report.named_ms,
        formed,
        tuple(loads),
        part_loads(network, loads),
        report.depth_max,
        int(least_depths(network).max()),
        Service.of(report, len(network), serve_s) if serve_s else None,
        history,
    )


Progress = Callable[[str], None]


def spread(run: Callable[..., Any], jobs: Iterable[tuple], on: Executor, tell: Progress, what: str) -> Iterator[Any]:
    """`run(*job)` for each job on an executor, results in the order of the jobs, told about as they come."""
    listed = list(jobs)
    for number, result in enumerate(in_order(on, run, listed)):
        yield result
        tell(f"{what} {number + 1}/{len(listed)}")
