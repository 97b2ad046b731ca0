# SPDX-License-Identifier: Apache-2.0
"""How fast the network heals: one fault a run, of every kind, at a drawn place and time."""

from __future__ import annotations

from dataclasses import dataclass
from random import Random

import numpy as np

from robotskin.layout.cell_network import CellNetwork
from robotskin.simulator import NetworkTrial, parse_faults
from robotskin_lab.bench.network_runs import RELEASE_S, STEP_S, run_to_balance, trial_of, wiring_of
from robotskin_lab.bench.network_set import draw, skins

KINDS = (
    "link",
    "cable",
    "one way out",
    "one way in",
    "cell",
    "cell with cable",
    "reboot",
    "zombie",
    "memory",
    "slow",
    "noise",
    "burst",
    "stuffed queue",
    "duplicate id",
    "section unit",
    "flap",
)
"""Kinds of single faults; the last is reported apart."""
SILENCING = ("cell", "cell with cable", "reboot", "zombie", "duplicate id")
"""Kinds that take a cell out of the network, for a while at least, and its cable with it."""
WATCHED_S = 0.15
"""About the time after the fault; it strikes a balanced network."""


@dataclass(frozen=True)
class Healing:
    """A fault and what it did, milliseconds; see `FaultOutcome` and `TrialReport` of the world.

    healed: every cell in reach had a way at the end. host_gap_ms: longest silence of a cell, fault included.
    thinned_out: the rate divisor of a cable was more than one after the fault. cable_lost: the fault took a cable away.
    """

    kind: str
    skin: str
    seed: int
    text: str
    recovery_ms: float
    cells_cut_off: int
    healed: bool
    host_gap_ms: float
    thinned_out: bool
    cable_lost: bool

    @property
    def overloaded(self) -> bool:
        """A skin that lost a cable and had more cells on another than that carries at 250 Hz: they send at less."""
        return self.cable_lost and self.thinned_out


def fault_text(kind: str, network: CellNetwork, random: Random, time_ms: float) -> str:
    """A fault of a kind at drawn places, as the world reads it."""
    link = network.links[draw(random, len(network.links))]
    cell, port = (int(link[0]), int(link[1])) if random.random() < 0.5 else (int(link[2]), int(link[3]))
    cable = network.cables[draw(random, len(network.cables))]
    units = sorted({(end.group, end.unit) for end in network.cables})
    unit = units.index((cable.group, cable.unit))
    at = f"@{time_ms:.3f}ms"
    texts = {
        "link": f"cut:cell={cell},port={port}",
        "cable": f"cut:unit={unit + 1},port={cable.port}",
        "one way out": f"oneway:cell={cell},port={port},way=out",
        "one way in": f"oneway:cell={cell},port={port},way=in",
        "cell": f"crash:cell={cell}",
        "cell with cable": f"crash:cell={cable.cell}",
        "reboot": f"reboot:cell={cell},off={0.1 + 9.9 * random.random():.3f}ms",
        "zombie": f"zombie:cell={cell}",
        "memory": f"ram:cell={cell},bytes=16,part=route",
        "slow": f"slow:cell={cell},by=200us,for=20ms",
        "noise": f"noise:cell={cell},port={port},rate=0.01,for=20ms",
        "burst": f"burst:cell={cell},port={port},share=1,for=5ms",
        "stuffed queue": f"stuff:cell={cell},port={port},frames=100",
        "duplicate id": f"duplicate_id:cell={cell},to={draw(random, len(network))}",
        "section unit": f"stop:unit={unit + 1}",
        "flap": f"flap:cell={cell},port={port},times=5,period=2ms",
    }
    return texts[kind] + at


def thins_out(trial: NetworkTrial) -> bool:
    """Whether cells of a cable send less than every sample."""
    network = trial.network
    return any(divisor > 1 for unit in range(network.unit_count) for divisor in network.rate_divisors(unit))


def run_to_full_rate(trial: NetworkTrial) -> None:
    """Run until no samples are thinned out, which they are for a while after a cable had too many cells."""
    end_s = trial.time_s + RELEASE_S
    while trial.time_s < end_s and thins_out(trial):
        trial.run_until(trial.time_s + STEP_S)


def heal(kind: str, skin: str, seed: int) -> Healing:
    """One run with one fault on a skin of the set with three cables (two section units where one of them stops)."""
    random = Random(f"fault {kind} {skin} {seed}")
    # Seeds 3, 7, ... of the set have two section units, so that what hung on the one that stops can go to the other.
    network = skins(skin, 3, (4 * seed + 3) % 100 if kind == "section unit" else seed)
    trial = trial_of(network, seed)
    run_to_balance(network, trial)
    run_to_full_rate(trial)
    trial.measure_anew()
    text = fault_text(kind, network, random, 1e3 * trial.time_s + 4 + 4 * random.random())
    (fault,) = parse_faults(text, wiring_of(network), seed + 1)
    trial.network.inject(fault)
    at_cable = kind in SILENCING and fault.cell in [cable.cell for cable in network.cables]
    begin_s, thinned_out = trial.time_s, False
    for step in range(1, round(WATCHED_S / STEP_S) + 1):
        trial.run_until(begin_s + step * STEP_S)
        thinned_out = thinned_out or thins_out(trial)
    report = trial.report()
    (outcome,) = report.outcomes
    return Healing(
        kind,
        skin,
        seed,
        text,
        outcome.recovery_ms,
        outcome.cells_cut_off,
        outcome.healed,
        report.host_gap_ms,
        thinned_out,
        at_cable or kind in ("cable", "section unit"),
    )


def recovery_figures(healings: list[Healing]) -> dict[str, float | int]:
    """The figures of the issue; half and worst over the runs in which a cell lost its way."""
    single = [healing for healing in healings if healing.kind != "flap"]
    hit = [healing.recovery_ms for healing in single if healing.cells_cut_off]
    figures: dict[str, float | int] = {
        "recovery_runs": len(single),
        "recovery_runs_cut_off": len(hit),
        "recovery_p50_ms": float(np.median(hit)),
        "recovery_max_ms": float(max(healing.recovery_ms for healing in single)),
        "recovery_unhealed": sum(not healing.healed for healing in healings),
        "host_gap_max_ms": float(max(healing.host_gap_ms for healing in single if not healing.overloaded)),
        "host_gap_overloaded_max_ms": max((one.host_gap_ms for one in single if one.overloaded), default=0.0),
    }
    for kind in KINDS:
        of_kind = [healing for healing in healings if healing.kind == kind]
        name = kind.replace(" ", "_")
        if of_kind:
            figures[f"recovery_{name}_max_ms"] = float(max(healing.recovery_ms for healing in of_kind))
        gaps = [healing.host_gap_ms for healing in of_kind if not healing.overloaded]
        if gaps:
            figures[f"host_gap_{name}_max_ms"] = float(max(gaps))
    return figures
