# SPDX-License-Identifier: Apache-2.0
"""Writes the table of balance's mechanisms in docs/network.md from what was measured of each."""

import json
from pathlib import Path

from robotskin_lab import page_table

PAGE = Path(__file__).with_name("network.md")
MEASURED = Path(__file__).with_name("balance_mechanisms.json")
FAMILIES = ("compact_3", "compact_4_5", "ring_12", "robot_1260", "robots")


def row(name: str, one: dict) -> str:
    """A mechanism: what it buys in each family, and the worst skin without it."""
    buys = " | ".join(f"{one[family]['percent']:.1f} ({100 * one[family]['better']:.0f})" for family in FAMILIES)
    worst = ", ".join(f"{one[family]['worst']:.2f}" for family in FAMILIES)
    return f"| {one['text']} (`{name}`) | {buys} | {worst} | {one['verdict']} |"


def with_table(page: str, measured: dict) -> str:
    """The page with the table as it should be; its two lines of head stay."""
    worst = ", ".join(f"{measured['worst'][family]:.2f}" for family in FAMILIES)
    shipping = f"| none is left out | | | | | | {worst} | |"
    rows = [shipping, *(row(name, one) for name, one in measured["mechanisms"].items())]
    return page_table.with_rows(page, "mechanisms", rows)


if __name__ == "__main__":
    measured = json.loads(MEASURED.read_text(encoding="utf-8"))
    PAGE.write_text(with_table(PAGE.read_text(encoding="utf-8"), measured), encoding="utf-8")
