# SPDX-License-Identifier: Apache-2.0
"""Writes docs/equations.md: where each equation of Cheng et al. 2019 is computed.

A comment that begins with `[Cheng19 eq. N]`, at a line of a source or right above it, marks the line that computes
equation N. Within a sentence or a docstring the same words only name it. `python docs/equation_table.py` prints the
lines, too.
"""

import re
from dataclasses import dataclass
from pathlib import Path

from symbols import ROOT, symbol_at

from robotskin_lab import page_table

PAGE = Path(__file__).with_name("equations.md")
SOURCES = ("firmware/**/*.c", "core/**/*.cpp", "lab/core/**/*.cpp", "python/**/*.py", "lab/python/**/*.py")
TAG = re.compile(r"(?://|/\*|#) *\[Cheng19 eq\. ([0-9, ]+)\]")

WHAT = {
    1: "pose of a cell relative to the one before it",
    2: "rotation between two cells from what both felt (Procrustes)",
    3: "pose of a cell along the shortest path to the root",
    4: "event of an ideal sensor: integral of the change",
    5: "event of an ideal sensor: distance from the last event",
    6: "send-on-delta: the change has reached the threshold",
    7: "an event is a value with its time",
    8: "amplitude of an acceleration while one joint swings",
    9: "when the maximum comes first",
    10: "when the minimum comes first",
    11: "sign of a motion along the normal",
    12: "weight of a joint for a cell",
    13: "activity matrix times map",
    14: "virtual force of a cell from force and proximity",
    15: "that force in the frame of the base",
    16: "joint torque of one cell",
    17: "joint torque of the skin",
    18: "tasks fused by weights",
    19: "tasks fused in null spaces",
    20: "null-space projectors",
    21: "projections between joint and cell",
    22: "wrench of a cell on its link",
    23: "wrench of all cells of a link",
    24: "wrench turned to the base",
    25: "joint torque of a wrench",
    26: "desired dynamics of a contact",
    27: "torques within limits; what they miss is handed on",
}
"""In our words, by number; of each equation that the paper has."""


@dataclass(frozen=True, order=True)
class Place:
    """A line that computes an equation."""

    equation: int
    path: str
    line: int
    symbol: str

    @property
    def of_product(self) -> bool:
        """Whether it is in what is installed."""
        return not self.path.startswith("lab/")


def places() -> list[Place]:
    """Every marked line, by equation."""
    found = []
    for pattern in SOURCES:
        for path in sorted(ROOT.glob(pattern)):
            text = path.read_text(encoding="utf-8")
            if "[Cheng19 eq." not in text:
                continue
            lines = text.splitlines()
            for at, line in enumerate(lines):
                for tag in TAG.finditer(line):
                    alone = line[: tag.start()].strip() == ""
                    computes = at + 1 if not alone else _next_code(lines, at + 1) + 1
                    name = symbol_at(path, computes)
                    found += [
                        Place(int(number), path.relative_to(ROOT).as_posix(), computes, name)
                        for number in tag[1].split(",")
                    ]
    return sorted(found)


def _next_code(lines: list[str], at: int) -> int:
    while lines[at].strip().startswith(("//", "/*", "*", "#")):
        at += 1
    return at


def table(found: list[Place]) -> list[str]:
    """The rows of the page: a place is a file and a function, so that other edits do not touch the page."""
    rows = ["| eq. | what | where |", "|---|---|---|"]
    for number, what in WHAT.items():
        there = sorted({(not p.of_product, p.path, p.symbol) for p in found if p.equation == number})
        links = [f"[`{symbol}`](../{path})" + (" (laboratory)" if lab else "") for lab, path, symbol in there]
        rows.append(f"| {number} | {what} | {', '.join(links) or 'open'} |")
    return rows


def with_table(page: str) -> str:
    """The page with the table as it should be."""
    return page_table.with_table(page, "table", table(places()))


if __name__ == "__main__":
    for place in places():
        print(f"{place.equation:3d}  {WHAT[place.equation]:60s}  {place.path}:{place.line} {place.symbol}")
    PAGE.write_text(with_table(PAGE.read_text(encoding="utf-8")), encoding="utf-8")
