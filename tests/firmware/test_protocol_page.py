# SPDX-License-Identifier: Apache-2.0
"""docs/protocol.md shows what the headers say."""

import re
from pathlib import Path

import protocol_tables

from robotskin import firmware

DOCS = Path(__file__).parents[2] / "docs"


def test_the_tables_are_those_of_the_headers() -> None:
    page = (DOCS / "protocol.md").read_text()
    assert page == protocol_tables.with_tables(page), "run make docs"


def test_every_frame_and_table_is_on_the_page() -> None:
    page = (DOCS / "protocol.md").read_text()
    shown = {name for name in protocol_tables.TABLES if f"<!-- table: {name} -->" in page}
    assert set(protocol_tables.TABLES) - shown == {"frame event"}  # the same as clock, and said so
    assert firmware.FRAMES["event"] == firmware.FRAMES["clock"]


def test_a_changed_table_is_noticed() -> None:
    page = (DOCS / "protocol.md").read_text()
    changed = page.replace("| 0 to 3 | 4 | `type` |", "| 0 to 4 | 5 | `type` |", 1)
    assert changed != page
    assert protocol_tables.with_tables(changed) == page


def test_every_rule_that_the_firmware_cites_is_on_the_page() -> None:
    page = (DOCS / "protocol.md").read_text()
    sources = [path.read_text() for path in (DOCS.parent / "firmware").rglob("*.[ch]")]
    cited = {int(number) for text in sources for number in re.findall(r"\bR(\d+)\b", text)}
    assert cited == set(range(1, 11))
    assert [int(number) for number in re.findall(r"^- \*\*R(\d+)\*\* ", page, re.MULTILINE)] == sorted(cited)
