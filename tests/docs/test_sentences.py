# SPDX-License-Identifier: Apache-2.0
"""Pages have short sentences: on average, and none that goes on for ever."""

import re
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[2]
PAGES = [
    "README.md",
    "ARCHITECTURE.md",
    "CONTRIBUTING.md",
    *sorted(page.relative_to(ROOT).as_posix() for page in (ROOT / "docs").glob("*.md")),
]
FRONT = [name for name in PAGES if re.match(r"README|ARCHITECTURE|docs/(tour|tutorial)", name)]
"""What a newcomer reads first."""
MEAN_WORDS, MOST_WORDS = 18, 35


def sentences(page: str, ends: str = ".!?") -> list[str]:
    """The sentences of a page in Markdown, of its tables too, which one of `ends` ends; code and drawings are none."""
    text = re.sub(r"```.*?```", "", page, flags=re.DOTALL)
    text = re.sub(r"<!--.*?-->", "", text, flags=re.DOTALL)
    blocks = re.split(r"\n\s*\n|\n(?= *\||#|- |\d+\. )", text)
    found: list[str] = []
    for block in blocks:
        if block.startswith(("    ", "|--")) or not block.strip():
            continue
        plain = re.sub(r"!?\[([^]]*)\]\([^)]*\)", r"\1", block)
        plain = re.sub(r"[`*]", "", plain)
        cells = plain.strip("| \n").split(" | ") if block.lstrip().startswith("|") else [plain]
        for cell in cells:
            found += [
                part for part in re.split(rf"(?<=[{ends}])\s+", cell.replace("\n", " ")) if re.search(r"\w", part)
            ]
    return [part for part in found if re.search(r"\w", part)]


def words(sentence: str) -> int:
    return len(re.findall(r"[A-Za-z0-9][^\s]*", sentence))


@pytest.mark.parametrize("name", PAGES)
def test_sentences_are_short(name: str) -> None:
    """A colon or a semicolon is a place to breathe, but ends no sentence."""
    page = (ROOT / name).read_text(encoding="utf-8")
    longest = max(sentences(page, ".!?:;"), key=words)
    assert words(longest) <= MOST_WORDS, f"{words(longest)} words: {longest}"
    running = [count for count in map(words, sentences(page)) if count > 3]  # cells of tables are often a name
    assert sum(running) / len(running) <= MEAN_WORDS


def test_on_the_first_pages_no_colon_parts_a_sentence() -> None:
    assert len(FRONT) >= 6
    for name in FRONT:
        longest = max(sentences((ROOT / name).read_text(encoding="utf-8")), key=words)
        assert words(longest) <= MOST_WORDS, f"{name}: {words(longest)} words: {longest}"


def test_a_long_sentence_is_seen() -> None:
    page = "# Title\n\nOne two three. " + "word " * 40 + "end.\n\n    code that is long " + "x " * 60 + "\n"
    assert max(map(words, sentences(page))) == 41
    assert len(sentences(page)) == 3
