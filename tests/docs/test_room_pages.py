# SPDX-License-Identifier: Apache-2.0
"""A page for each room says the idea first and the figures apart, and the index lists every page."""

import re
from pathlib import Path

import pytest

DOCS = Path(__file__).parents[2] / "docs"
ROOMS = ["network", "control", "selfconfig", "driver", "world", "layout", "recording", "firmware_on_a_chip"]


@pytest.mark.parametrize("room", ROOMS)
def test_a_page_of_a_room_has_idea_and_figures(room: str) -> None:
    headings = re.findall(r"^## (.+)$", (DOCS / f"{room}.md").read_text(encoding="utf-8"), re.MULTILINE)
    assert headings[0] == "Idea"
    assert headings.count("Figures") == 1


def test_the_index_has_every_page() -> None:
    listed = set(re.findall(r"\]\(([a-z_]+\.md)\)", (DOCS / "README.md").read_text(encoding="utf-8")))
    pages = {page.name for page in DOCS.glob("*.md")} - {"README.md", "index.md"}
    assert pages == listed
    shown = re.findall(r"^([a-z_]+)$", (DOCS / "index.md").read_text(encoding="utf-8"), re.MULTILINE)
    assert sorted(f"{page}.md" for page in shown) == sorted(pages), "the front page of the HTML shows each once"


def test_no_page_shows_what_an_earlier_version_printed() -> None:
    for page in DOCS.glob("*.md"):
        assert not re.search(r"(earlier|older) version", page.read_text(encoding="utf-8")), page.name
