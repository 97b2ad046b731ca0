# SPDX-License-Identifier: Apache-2.0
"""What became of faults: named right, not at all, or healthy cells named."""

from __future__ import annotations

from collections import Counter
from collections.abc import Sequence
from dataclasses import dataclass, field

import numpy as np

from robotskin.health import Finding, Kind
from robotskin.health.kinds import ILLNESSES
from robotskin_lab.bench.health_faults import Fault

Named = dict[int, tuple[Finding, float]]
"""The last name of each cell that was given one, and since when, in seconds of the run."""


class Names:
    """Follows what a watch finds."""

    def __init__(self) -> None:
        self._first: Named = {}
        self.named: Named = {}

    def look(self, findings: Sequence[Finding], time_s: float) -> None:
        """After a judgement."""
        for finding in findings:
            before = self._first.get(finding.cell)
            if before is None or before[0].kinds != finding.kinds:
                self._first[finding.cell] = (finding, time_s)
            self.named[finding.cell] = self._first[finding.cell]


@dataclass
class Score:
    """What became of the faults of some runs."""

    named: dict[Kind, list[bool]] = field(default_factory=lambda: {kind: [] for kind in Kind})
    shared: int = 0
    seconds: list[float] = field(default_factory=list)
    false: int = 0
    cell_seconds: float = 0.0
    wrong: Counter[str] = field(default_factory=Counter)
    false_kinds: Counter[str] = field(default_factory=Counter)

    def take(self, faults: Sequence[Fault], named: Named, cells: int, seconds: float) -> None:
        """One run."""
        ill = {fault.cell for fault in faults}
        for fault in faults:
            finding, at_s = named.get(fault.cell, (None, 0.0))
            right = finding is not None and fault.kind in finding.kinds
            self.named[fault.kind].append(right)
            if fault.kind is Kind.cut_off:
                self._healthy(finding if not right else None)
                continue
            if right and finding is not None:
                self.shared += finding.or_kind is not None
                self.seconds.append(at_s - fault.begin_s)
            else:
                self.wrong[f"{fault.kind.name} as {finding.kind.name if finding else 'nothing'}"] += 1
        for cell, (finding, _) in named.items():
            if cell not in ill:
                self._healthy(finding)
        self.cell_seconds += (cells - len(ill)) * seconds

    def _healthy(self, finding: Finding | None) -> None:
        """A name that a healthy cell was given wrongly."""
        if finding is not None:
            self.false += 1
            self.false_kinds[finding.kind.name] += 1

    def add(self, other: Score) -> None:
        """The runs of another."""
        for kind, rights in other.named.items():
            self.named[kind] += rights
        self.shared += other.shared
        self.seconds += other.seconds
        self.false += other.false
        self.cell_seconds += other.cell_seconds
        self.wrong += other.wrong
        self.false_kinds += other.false_kinds

    @property
    def cases(self) -> int:
        """Faults: a cell that others cut off has none."""
        return sum(len(self.named[kind]) for kind in ILLNESSES)

    @property
    def recall(self) -> float:
        """Of all faults."""
        return sum(sum(self.named[kind]) for kind in ILLNESSES) / max(self.cases, 1)

    @property
    def false_share(self) -> float:
        """Healthy cells named, per cell and ten minutes."""
        return self.false / max(self.cell_seconds / 600, 1e-9)

    def time_to_name_s(self, share: float) -> float:
        """Within which this share of the faults that were named right had their name."""
        return float(np.quantile(self.seconds, share)) if self.seconds else float("nan")


def told(counts: Counter[str]) -> str:
    """The most of them."""
    return "; ".join(f"{count} {what}" for what, count in counts.most_common(6)) or "none"
