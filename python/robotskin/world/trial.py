# SPDX-License-Identifier: Apache-2.0
"""A network without a body, run in virtual time with its faults and measured: formation, recovery, gaps, loads.

In: which cell is wired to which, faults, a seed. Out: what happened, in numbers, and the hash of every frame and
datagram. One seed gives one run. What can go wrong: a fault that is misspelt or whose target does not exist
(FaultError).
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import Any, Protocol

import numpy as np
from numpy.typing import NDArray

from robotskin import simulator as core
from robotskin.errors import InputError
from robotskin.keys import SkinKeys
from robotskin.world.ideal import default_processor


class Skin(Protocol):
    """Cells and cables, such as a `CellNetwork` of the layout package."""

    @property
    def neighbours(self) -> NDArray[np.int32]:
        """(N, 4, 2): for own port p at row p - 1 the neighbour's index or -1, and its port."""

    @property
    def id(self) -> NDArray[np.uint16]:
        """(N,) kept in the cells' flash; 0 where the network shall name the cell."""

    def unit_descriptions(self) -> list[core.UnitDescription]:
        """The section units and the cells at their ports."""


def wiring_of(skin: Skin) -> core.Wiring:
    """The wiring of a skin as the simulated network takes it."""
    return core.Wiring(skin.neighbours, [int(i) for i in skin.id], skin.unit_descriptions())


def run_trial(
    skin: Skin,
    seconds: float,
    seed: int = 1,
    faults: str | Sequence[core.Fault] = "",
    *,
    rate_hz: int = 250,
    line: core.LineQuality | None = None,
    progress: Callable[[float, core.NetworkTrial], None] | None = None,
) -> core.TrialReport:
    """Run a network from power-on and measure it.

    Args:
        skin: N cells and their cables.
        seconds: of virtual time.
        seed: of clocks, wires, boots, and of faults drawn by `random:N`.
        faults: as text (`core.fault_help()`) or values.
        rate_hz: samples a second of each cell: 0, 63, 125 or 250.
        line: quality of wires and clocks.
        progress: called with the virtual time in seconds and the trial, every 10 ms of it.

    Raises:
        FaultError: a fault that cannot be read, or whose target does not exist.
        InputError: a fault that would come after the end.
    """
    wiring = wiring_of(skin)
    options = core.NetworkOptions()
    options.processor = default_processor()
    options.seed, options.clock_rate_hz = seed, rate_hz
    options.set_cell_key(SkinKeys.of_seed(seed).cell_key)
    options.faults = core.parse_faults(faults, wiring, seed) if isinstance(faults, str) else list(faults)
    for fault in options.faults:
        if fault.time_ns >= 1e9 * seconds:
            raise InputError(f"fault {fault}: the run ends before it, after {seconds:g} s")
    if line is not None:
        options.line = line
    trial = core.NetworkTrial(wiring, options)
    steps = max(round(100 * seconds), 1)
    for step in range(1, steps + 1):
        trial.run_until(seconds * step / steps)
        if progress is not None:
            progress(trial.time_s, trial)
    return trial.report()


def figures_of(report: core.TrialReport) -> dict[str, Any]:
    """A report as flat numbers, fit for JSON; of faults the worst. What no sample has told is None."""
    heard = report.samples_heard > 0
    loads = [load for unit in report.port_loads for load in unit]
    return {
        "seconds": report.seconds,
        "formation_ms": report.formation_ms,
        "named_ms": report.named_ms,
        "cells_in_reach": report.cells_in_reach,
        "whole": int(report.whole),
        "faults": len(report.outcomes),
        "recovery_max_ms": report.recovery_max_ms,
        "rejoin_max_ms": max((outcome.rejoin_ms for outcome in report.outcomes), default=0.0),
        "host_gap_ms": report.host_gap_ms if heard else None,
        "samples_sent": report.samples_sent,
        "samples_heard": report.samples_heard,
        "samples_lost": report.samples_lost,
        "samples_twice": report.samples_twice,
        "latency_mean_ms": report.latency_mean_ms if heard else None,
        "latency_p99_ms": report.latency_p99_ms if heard else None,
        "port_load_max": max(loads, default=0),
        "port_load_min": min(loads, default=0),
        "depth_max": report.depth_max,
        "extra_depth_mean": report.extra_depth_mean,
        "extra_depth_max": report.extra_depth_max,
        "frames_lost": report.frames_lost,
        "frames_dropped": report.frames_dropped,
        "queue_peak": report.queue_peak,
        "hops": report.counts.frames_delivered,
        "cell_steps": report.counts.cell_steps,
        "log_hash": f"{report.log_hash:016x}",
    }
