# SPDX-License-Identifier: Apache-2.0
"""Writes the table of docs/imperfections.md from core/world/imperfections.hpp (through its binding)."""

from pathlib import Path

from robotskin.simulator import Imperfections
from robotskin_lab import page_table

PAGE = Path(__file__).with_name("imperfections.md")


def table() -> list[str]:
    """Every imperfection, one a row."""
    default, ideal = Imperfections(), Imperfections.ideal()
    lines = ["| name | default | ideal | unit | what it is | source |", "|---|---|---|---|---|---|"]
    for name, unit, meaning, source in Imperfections.table():
        lines.append(
            f"| `{name}` | {getattr(default, name):g} | {getattr(ideal, name):g} | {unit} | {meaning} | {source} |"
        )
    return lines


def with_table(page: str) -> str:
    """The page with its table as the header has it."""
    return page_table.with_table(page, "table: imperfections", table())


if __name__ == "__main__":
    PAGE.write_text(with_table(PAGE.read_text()))
