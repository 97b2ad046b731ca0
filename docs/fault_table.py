# SPDX-License-Identifier: Apache-2.0
"""Writes the table of faults in docs/network.md from the files that define them (through their binding)."""

from pathlib import Path

from robotskin.simulator import fault_help
from robotskin_lab import page_table

PAGE = Path(__file__).with_name("network.md")


def with_table(page: str) -> str:
    """The page with the table as it should be; its two lines of head stay."""
    rows = [f"| `{keys}` | {text} |" for keys, _, text in (line.partition("  ") for line in fault_help().splitlines())]
    return page_table.with_rows(page, "faults", rows)


if __name__ == "__main__":
    PAGE.write_text(with_table(PAGE.read_text(encoding="utf-8")), encoding="utf-8")
