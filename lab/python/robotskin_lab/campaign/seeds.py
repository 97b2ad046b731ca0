# SPDX-License-Identifier: Apache-2.0
"""Many seeds wherever an executor runs them, their verdicts, and what they drew."""

from __future__ import annotations

import dataclasses
import random
import time
from collections import Counter
from collections.abc import Callable, Iterable, Iterator
from typing import Any

from robotskin_lab._lab import campaign as core
from robotskin_lab.executors import Executor, Processes, in_order

BATCH = 20  # seeds that a worker takes at once


def fresh_seed() -> int:
    """A first seed that no run has had, but by chance of one in millions; every run tells it, so that it repeats."""
    return random.SystemRandom().randrange(1, 1 << 40)


@dataclasses.dataclass(frozen=True)
class BrokenSeed:
    """A seed that broke an invariant: `case` is what it drew, `breaks` a line each, `invariants` their names."""

    seed: int
    case: str
    breaks: tuple[str, ...]
    invariants: tuple[str, ...]


@dataclasses.dataclass
class Distribution:
    """What the seeds drew, as counts by value; cells in classes that double."""

    cells: Counter[str] = dataclasses.field(default_factory=Counter)
    shapes: Counter[str] = dataclasses.field(default_factory=Counter)
    ports: Counter[int] = dataclasses.field(default_factory=Counter)
    section_units: Counter[int] = dataclasses.field(default_factory=Counter)
    faults: Counter[int] = dataclasses.field(default_factory=Counter)
    kinds: Counter[str] = dataclasses.field(default_factory=Counter)
    conditions: Counter[str] = dataclasses.field(default_factory=Counter)
    least_after_ms: float = float("inf")  # from the last fault's last effect to the end

    def add(self, case: core.FaultCase) -> None:
        """Count one case."""
        low = 20
        while 2 * low <= case.cells:
            low *= 2
        self.cells[f"{low} to {min(2 * low - 1, 400)}"] += 1
        self.shapes[case.shape] += 1
        self.ports[case.ports] += 1
        self.section_units[case.section_units] += 1
        self.faults[len(case.faults)] += 1
        self.kinds.update(fault.partition("@")[0].partition(":")[0] for fault in case.faults)
        self.conditions["keyed"] += case.keyed
        self.conditions["lossy"] += not case.whole_lines
        self.conditions["while forming"] += case.while_forming
        self.conditions["event mode"] += case.events
        if case.events:
            self.conditions[f"events of {case.touched_percent} % at {case.events_hz} Hz"] += 1
        self.conditions["torque sums"] += case.limbs > 0
        self.conditions["orders from the host"] += case.orders
        self.conditions["own torques"] += case.touch
        self.conditions["1.3 s after the faults"] += case.after_ns >= 1_300_000_000
        self.least_after_ms = min(self.least_after_ms, 1e-6 * case.after_ns)

    def merge(self, other: Distribution) -> None:
        """Add the counts of another."""
        for field in dataclasses.fields(self):
            if field.name != "least_after_ms":
                getattr(self, field.name).update(getattr(other, field.name))
        self.least_after_ms = min(self.least_after_ms, other.least_after_ms)

    def __str__(self) -> str:
        lines = []
        for field in dataclasses.fields(self):
            value = getattr(self, field.name)
            if isinstance(value, Counter):
                ordered = sorted(value.items(), key=lambda item: (len(str(item[0])), str(item[0])))
                counts = ", ".join(f"{key}: {count}" for key, count in ordered)
                lines.append(f"{field.name.replace('_', ' ')}: {counts}")
        lines.append(f"least time after the last fault: {self.least_after_ms:.0f} ms")
        return "\n".join(lines)


@dataclasses.dataclass
class SeedsReport:
    """Sums over seeds; `cpu_s` is processor time of all workers.

    verdicts: a line a seed, in their order: seed, hash of every frame and datagram, events, and what broke. Equal seeds
    of the same code have equal verdicts, wherever they ran. crowded_out_most: samples that found no room after one
    fault, in trees within load, at most; excused_most: false samples that damaged memory excused in a case, at most;
    lost_overloaded: samples lost by trees that had more than their cables carry, of all seeds.
    """

    seeds: int = 0
    breaks: int = 0
    cpu_s: float = 0.0
    simulated_s: float = 0.0
    events: int = 0
    broken: list[BrokenSeed] = dataclasses.field(default_factory=list)
    distribution: Distribution = dataclasses.field(default_factory=Distribution)
    longest_wait_ms: float = 0.0
    largest_control_share: float = 0.0
    crowded_out_most: int = 0
    excused_most: int = 0
    lost_overloaded: int = 0
    verdicts: list[str] = dataclasses.field(default_factory=list)

    def merge(self, other: SeedsReport) -> None:
        """Add another's sums."""
        self.seeds += other.seeds
        self.breaks += other.breaks
        self.cpu_s += other.cpu_s
        self.simulated_s += other.simulated_s
        self.events += other.events
        self.broken += other.broken
        self.distribution.merge(other.distribution)
        self.longest_wait_ms = max(self.longest_wait_ms, other.longest_wait_ms)
        self.largest_control_share = max(self.largest_control_share, other.largest_control_share)
        self.crowded_out_most = max(self.crowded_out_most, other.crowded_out_most)
        self.excused_most = max(self.excused_most, other.excused_most)
        self.lost_overloaded += other.lost_overloaded
        self.verdicts += other.verdicts


def _run_batch(seeds: list[int], ideal_processors: bool = False) -> SeedsReport:
    batch = SeedsReport()
    start_s = time.process_time()
    for seed in seeds:
        case = core.draw_case(seed, ideal_processors)
        report = core.run_case(case)
        batch.seeds += 1
        batch.breaks += report.break_count
        batch.events += report.events
        batch.simulated_s += report.simulated_s
        batch.longest_wait_ms = max(batch.longest_wait_ms, report.longest_wait_ms)
        batch.largest_control_share = max(batch.largest_control_share, report.largest_control_share)
        batch.crowded_out_most = max(batch.crowded_out_most, report.crowded_out_most)
        batch.excused_most = max(batch.excused_most, report.excused)
        batch.lost_overloaded += report.lost_overloaded
        batch.distribution.add(case)
        breaks = "; ".join(str(broken) for broken in report.breaks) or "whole"
        batch.verdicts.append(f"{seed} {report.log_hash:016x} {report.events} {breaks}")
        if report.break_count > 0:
            names = tuple(dict.fromkeys(broken.invariant for broken in report.breaks))
            batch.broken.append(BrokenSeed(seed, str(case), tuple(str(broken) for broken in report.breaks), names))
    batch.cpu_s = time.process_time() - start_s
    return batch


def _batches(seeds: Iterable[int], until_s: float | None) -> Iterator[list[int]]:
    batch: list[int] = []
    for seed in seeds:
        if until_s is not None and time.monotonic() >= until_s:
            break
        batch.append(seed)
        if len(batch) == BATCH:
            yield batch
            batch = []
    if batch:
        yield batch


def run_seeds(
    seeds: Iterable[int],
    *,
    on: Executor | None = None,
    seconds: float | None = None,
    told: Callable[[BrokenSeed], None] | None = None,
    ideal_processors: bool = False,
) -> SeedsReport:
    """Run seeds on an executor (a process a processor by default), for at most so many seconds; sums of all.

    `told` is called with every broken seed, in the order of the seeds. ideal_processors: cells compute in no time.
    """
    total = SeedsReport()
    batches = _batches(seeds, None if seconds is None else time.monotonic() + seconds)
    for batch in in_order(on or Processes(), _run_batch, ((one, ideal_processors) for one in batches)):
        total.merge(batch)
        if told is not None:
            for broken in batch.broken:
                told(broken)
    return total


def campaign(
    seeds: int,
    first_seed: int = 1,
    *,
    on: Executor | None = None,
    told: Callable[[BrokenSeed], None] | None = None,
    ideal_processors: bool = False,
) -> dict[str, Any]:
    """Run `seeds` seeds from `first_seed` on; sums, what was drawn, and the seeds that broke an invariant.

    Keys: `fault_seeds_run`, `invariant_breaks` (of all seeds), `cpu_s_per_seed`, `simulated_s`, `events`,
    `longest_wait_ms`, `largest_control_share`, `crowded_out_most`, `excused_most` and `lost_overloaded` (see
    `SeedsReport`), `distribution` (a `Distribution`, which prints itself) and `broken` (a
    list of `BrokenSeed`). The mutants are apart: `caught_mutants`. ideal_processors: cells compute in no time.
    """
    total = run_seeds(range(first_seed, first_seed + seeds), on=on, told=told, ideal_processors=ideal_processors)
    return {
        "fault_seeds_run": total.seeds,
        "invariant_breaks": total.breaks,
        "cpu_s_per_seed": total.cpu_s / max(total.seeds, 1),
        "simulated_s": total.simulated_s,
        "events": total.events,
        "longest_wait_ms": total.longest_wait_ms,
        "largest_control_share": total.largest_control_share,
        "crowded_out_most": total.crowded_out_most,
        "excused_most": total.excused_most,
        "lost_overloaded": total.lost_overloaded,
        "distribution": total.distribution,
        "broken": sorted(total.broken, key=lambda broken: broken.seed),
    }
