# SPDX-License-Identifier: Apache-2.0
"""Writes the table of docs/imperfections.md from core/world/imperfections.hpp (through its binding)."""

import re
from pathlib import Path

from robotskin.simulator import Imperfections

PAGE = Path(__file__).with_name("imperfections.md")


def table() -> str:
    """Every imperfection, one a row."""
    default, ideal = Imperfections(), Imperfections.ideal()
    lines = ["| name | default | ideal | unit | what it is | source |", "|---|---|---|---|---|---|"]
    for name, unit, meaning, source in Imperfections.table():
        lines.append(
            f"| `{name}` | {getattr(default, name):g} | {getattr(ideal, name):g} | {unit} | {meaning} | {source} |"
        )
    return "\n".join(lines)


def with_table(page: str) -> str:
    """The page with its table as the header has it."""
    return re.sub(
        r"(<!-- table: imperfections -->\n).*?(<!-- end -->)",
        lambda m: f"{m[1]}{table()}\n{m[2]}",
        page,
        flags=re.DOTALL,
    )


if __name__ == "__main__":
    PAGE.write_text(with_table(PAGE.read_text()))
