# SPDX-License-Identifier: Apache-2.0
"""Ill cells by name: random faults of ten kinds on simulated sensors, with plain thresholds beside."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field
from typing import Annotated, Any

import numpy as np
import typer

from robotskin import layout, robots
from robotskin.health import Finding, HealthWatch, Kind
from robotskin_lab.bench.health_faults import Fault
from robotskin_lab.bench.health_rig import RATE_HZ, Rig
from robotskin_lab.bench.health_thresholds import Thresholds
from robotskin_lab.bench.progress import tell

SETTLE_S = 60.0
JUDGED_S = 75.0
SHARE = 0.15


@dataclass
class Score:
    """What became of the faults of some runs."""

    named: dict[Kind, list[bool]] = field(default_factory=lambda: {kind: [] for kind in Kind})
    shared: int = 0
    seconds: list[float] = field(default_factory=list)
    false: int = 0
    cell_seconds: float = 0.0
    wrong: dict[str, int] = field(default_factory=dict)
    false_kinds: dict[str, int] = field(default_factory=dict)

    def take(self, faults: list[Fault], named: dict[int, tuple[Finding, float]], cells: int, seconds: float) -> None:
        """One run: the last name of each cell that was given one, and when, in seconds of the run."""
        ill = {fault.cell for fault in faults}
        for fault in faults:
            finding, at_s = named.get(fault.cell, (None, 0.0))
            right = finding is not None and fault.kind in finding.kinds
            self.named[fault.kind].append(right)
            if right and finding is not None:
                self.shared += finding.or_kind is not None
                self.seconds.append(at_s - fault.begin_s)
            else:
                what = f"{fault.kind.name} as {finding.kind.name if finding else 'nothing'}"
                self.wrong[what] = self.wrong.get(what, 0) + 1
        for cell, (finding, _) in named.items():
            if cell not in ill:
                self.false += 1
                self.false_kinds[finding.kind.name] = self.false_kinds.get(finding.kind.name, 0) + 1
        self.cell_seconds += (cells - len(ill)) * seconds

    @property
    def recall(self) -> float:
        """Of all faults."""
        every = [right for rights in self.named.values() for right in rights]
        return float(np.mean(every)) if every else 0.0

    @property
    def false_share(self) -> float:
        """Healthy cells named, per cell and ten minutes."""
        return self.false / max(self.cell_seconds / 600, 1e-9)


def run(
    *,
    seed: int = 1,
    runs: Annotated[int, typer.Option(help="Runs, each with its own skin, motion and faults.")] = 4,
    robot: Annotated[str, typer.Option(help="Whose finished skin.")] = "ur5",
    share: Annotated[float, typer.Option(help="Of the cells fall ill, a minute after the start.")] = SHARE,
    healthy_minutes: Annotated[float, typer.Option(help="One more run without faults of so many minutes.")] = 0.0,
) -> dict[str, Any]:
    """Name cells that fall ill while a robot works: recall, false names, time to the name, by kind."""
    body, skin = robots.load(robot), layout.finished(robot)
    ours, plain = Score(), Score()
    for number in range(runs):
        tell(f"health: run {number + 1} of {runs}")
        _one(Rig(body, skin, seed * 1000 + number, SETTLE_S + JUDGED_S, share, SETTLE_S), ours, plain)
    if healthy_minutes > 0:
        tell(f"health: {healthy_minutes:g} minutes without faults")
        _one(Rig(body, skin, seed * 1000 + 999, 60 * healthy_minutes, 0.0, 0.0), ours, plain)
    tell("")
    return _figures(ours, plain)


def _one(rig: Rig, ours: Score, plain: Score) -> None:
    watch = HealthWatch(rig.skin, rig.robot.core)
    thresholds = Thresholds(len(rig.layout))
    first: dict[int, tuple[Finding, float]] = {}
    named: dict[int, tuple[Finding, float]] = {}
    for step in range(len(rig.times)):
        now_ns = rig.step(step)
        thresholds.tick(rig.state, float(rig.times[step]))
        if not watch.tick(now_ns, rig.state, rig.position[step], rig.velocity[step]):
            continue
        for finding in watch.findings:
            before = first.get(finding.cell)
            if before is None or before[0].kinds != finding.kinds:
                first[finding.cell] = (finding, float(rig.times[step]))
            named[finding.cell] = first[finding.cell]
    ours.take(rig.faults, named, len(rig.layout), len(rig.times) / RATE_HZ)
    plain.take(rig.faults, thresholds.named, len(rig.layout), len(rig.times) / RATE_HZ)


def _figures(ours: Score, plain: Score) -> dict[str, Any]:
    cases = sum(len(rights) for rights in ours.named.values())
    figures: dict[str, Any] = {
        "cases": cases,
        "fault_recall": ours.recall,
        "fault_false_share": ours.false_share,
        "fault_shared_name_share": ours.shared / max(cases, 1),
        "time_to_name_p50_s": _quantile(ours.seconds, 0.5),
        "time_to_name_p95_s": _quantile(ours.seconds, 0.95),
        "cell_hours": ours.cell_seconds / 3600,
        "peer_thresholds_recall": plain.recall,
        "peer_thresholds_false_share": plain.false_share,
    }
    each: Callable[[Kind], float] = lambda kind: float(np.mean(ours.named[kind]))  # noqa: E731
    figures |= {f"recall_{kind.name}": each(kind) for kind in Kind if ours.named[kind]}
    figures["missed_most"] = _told(ours.wrong)
    figures["false_most"] = _told(ours.false_kinds)
    return figures


def _quantile(values: list[float], share: float) -> float:
    return float(np.quantile(values, share)) if values else float("nan")


def _told(counts: dict[str, int]) -> str:
    most = sorted(counts.items(), key=lambda item: -item[1])[:6]
    return "; ".join(f"{count} {what}" for what, count in most) or "none"
