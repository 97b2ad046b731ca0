# SPDX-License-Identifier: Apache-2.0
"""Figures with the bounds they have to keep, the table that shows both, and their file."""

from __future__ import annotations

import json
import math
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from rich.console import Console
from rich.table import Table
from rich.text import Text

import robotskin
from robotskin.whole_file import whole_file

__all__ = ["Bound", "broken", "report", "share_told", "table_of", "tell_broken", "write_figures"]


@dataclass(frozen=True)
class Bound:
    """The range in which a figure must lie, ends included."""

    figure: str
    least: float = -math.inf
    most: float = math.inf

    def holds(self, figures: Mapping[str, float]) -> bool:
        """Whether the figure is there, is a number, and lies in the range."""
        value = figures.get(self.figure, math.nan)
        return self.least <= value <= self.most

    def __str__(self) -> str:
        if self.least == self.most:
            return f"= {self.least:g}"
        if math.isinf(self.most):
            return f"≥ {self.least:g}"
        if math.isinf(self.least):
            return f"≤ {self.most:g}"
        return f"{self.least:g} … {self.most:g}"


def share_told(share: float) -> str:
    """A share in percent, for people: what is there never looks like none."""
    return "less than 0.01%" if 0.0 < share < 1e-4 else f"{share:.2%}"


def broken(bounds: Sequence[Bound], figures: Mapping[str, float]) -> list[Bound]:
    """The bounds that do not hold."""
    return [bound for bound in bounds if not bound.holds(figures)]


def report(
    console: Console,
    title: str,
    figures: Mapping[str, float],
    bounds: Sequence[Bound],
    seed: int,
    json_file: Path | None,
    remarks: Iterable[str] = (),
) -> int:
    """End a scripted run: print the table and the remarks that say anything, write the figures, name what is broken.

    Returns the exit status: 0 if all bounds hold, else 1.
    """
    console.print(table_of(title, figures, bounds))
    for remark in filter(None, remarks):
        console.print(remark, markup=False, highlight=False, soft_wrap=True)
    if json_file is not None:
        write_figures(json_file, seed, figures)
    return tell_broken(console, bounds, figures)


def tell_broken(console: Console, bounds: Sequence[Bound], figures: Mapping[str, float]) -> int:
    """Print a line for each bound that does not hold: the figure, its value, what it must be. Returns the exit status:
    0 if all hold, else 1."""
    missed = broken(bounds, figures)
    for bound in missed:
        value = f"is {figures[bound.figure]:.4g}" if bound.figure in figures else "was not measured"
        line = f"broken: {bound.figure} {value}, must be {bound}"
        console.print(line, style="bold red", markup=False, highlight=False, soft_wrap=True)
    return 1 if missed else 0


def table_of(title: str, figures: Mapping[str, float], bounds: Sequence[Bound]) -> Table:
    """All figures, with the bound of those that have one and whether it holds."""
    table = Table(title=title)
    for heading in ("figure", "measured", "bound", ""):
        table.add_column(heading, justify="right" if heading == "measured" else "left")
    by_name = {bound.figure: bound for bound in bounds}
    for name, value in figures.items():
        bound = by_name.get(name)
        verdict = Text()
        if bound is not None:
            verdict = Text("holds", "green") if bound.holds(figures) else Text("BROKEN", "bold red")
        number = f"{value:.6g}" if isinstance(value, float) else str(value)
        table.add_row(name, number, str(bound or ""), verdict)
    return table


def write_figures(file: Path, seed: int, figures: Mapping[str, Any]) -> dict[str, Any]:
    """Write figures with seed and version as one flat JSON object, whole or not at all; return what was written.

    A folder that is not there is made.
    """
    whole = {"seed": seed, "version": robotskin.__version__, **figures}
    file.parent.mkdir(parents=True, exist_ok=True)
    with whole_file(file) as partial:
        partial.write_text(json.dumps(whole, indent=2) + "\n")
    return whole
