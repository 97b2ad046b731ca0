# SPDX-License-Identifier: Apache-2.0
"""Figures in the running text of pages: each between two comments that name its run, its key and its format.

    recovers within <!-- network.recovery_p50_ms .1f -->3.2<!-- --> ms

A key such as `one/other` is the ratio of two figures, which is taken seed by seed.
The comments are not shown. `robotskin reproduce --table` writes what stands between them.
"""

from __future__ import annotations

import re
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

from robotskin_lab.reproduce.result import FOLDER, Result, ResultError, load

CITED = re.compile(r"<!-- (?P<run>[a-z]\w*)\.(?P<key>\w+(?:/\w+)?) (?P<format>[^\s-]\S*) -->(?P<said>[^<]*)<!-- -->")


def figure(cited: re.Match[str], folder: Path = FOLDER) -> str:
    """What should stand between the comments: the most of the seeds, or what the format begins with: `least:`, `mean:`.

    Raises:
        ResultError: no such result is kept, or it has no such figure.
    """
    result: Result = load(cited["run"], folder)
    way, _, form = cited["format"].rpartition(":")
    values = result.worst({cited["key"]: way or "most"})
    if cited["key"] not in values:
        raise ResultError(f"{cited[0]}: {result.run}.json has no figure {cited['key']!r}")
    return format(values[cited["key"]], form)


def with_figures(page: str, folder: Path = FOLDER) -> str:
    """The page with every cited figure as the kept results have it."""

    def said(cited: re.Match[str]) -> str:
        return f"<!-- {cited['run']}.{cited['key']} {cited['format']} -->{figure(cited, folder)}<!-- -->"

    return CITED.sub(said, page)


def uncited(page: str) -> list[str]:
    """The lines of sections called Figures, and of sections in them, that say a figure and cite no result.

    A figure is a number with a fraction or a unit. One in backticks belongs to a set-up; 95 % and 99 % name a quantile.
    A section that says `UNSTORED` is left out; `unstored` finds those.
    """
    return [line for section in _figure_sections(page) if not section.says(UNSTORED) for line in section.uncited()]


def uncited_runs(page: str) -> list[str]:
    """The sentences outside of those sections that say of which runs a figure is, and cite no result.

    So says one that has a seed by number, a median, a worst, processor time, or that something was measured or took so
    long, beside a figure. Backticks exempt none there.
    """
    return [
        sentence
        for section in _sections(page)
        if not section.of_figures
        for sentence in section.sentences()
        if _OF_RUNS.search(sentence) and _says_a_figure(sentence.replace("`", " "))
    ]


def unstored(page: str) -> list[str]:
    """The headings in sections called Figures that say that no stored result holds theirs."""
    return [section.heading for section in _figure_sections(page) if section.says(UNSTORED)]


UNSTORED = "No stored result holds these figures"
_NUMBER = re.compile(r"(?<![\w.(])(?!9[59] %)\d+(?:[.,]\d+| ?(?:%|°|(?:ms|µs|mm|N|s)\b))")
_OF_RUNS = re.compile(
    r"\bseeds? \d|\bmedians?\b|\bat worst\b|\bthe worst\b|\bprocessor time\b|\bmeasured\b|\btook\b", re.IGNORECASE
)
_MARK = re.compile(r"<!-- (?:end|mechanisms|results|differences|table: \w+) -->")
"""Around what is made from a file."""
_CODE = re.compile(r"`[^`]*`")


def _says_a_figure(text: str) -> bool:
    return bool(_NUMBER.search(_CODE.sub("", CITED.sub("", text))))


@dataclass
class _Section:
    heading: str
    of_figures: bool
    lines: list[str]

    def says(self, sentence: str) -> bool:
        return sentence in " ".join(self.lines)

    def uncited(self) -> list[str]:
        return [line for line in self.lines if _says_a_figure(line)]

    def sentences(self) -> list[str]:
        """Of paragraphs, items and rows."""
        blocks = re.split(r"\n\s*\n|\n(?= *(?:\||- |\d+\. ))", "\n".join(self.lines))
        return [part for block in blocks for part in re.split(r"(?<=[.!?:])\s", block.replace("\n", " "))]


def _figure_sections(page: str) -> Iterator[_Section]:
    """Each heading within Figures with its own lines."""
    return (section for section in _sections(page) if section.of_figures)


def _sections(page: str) -> Iterator[_Section]:
    """Each heading with its own lines, without code blocks and tables that are made from files."""
    figures_level, fenced, made = 0, False, False
    section = _Section("", False, [])
    for line in page.splitlines():
        if line.startswith("```"):
            fenced = not fenced
        elif _MARK.fullmatch(line):
            made = "end" not in line
        elif fenced or made or line.startswith("    "):
            continue
        elif line.startswith("#"):
            yield section
            level = len(line) - len(line.lstrip("#"))
            if figures_level and level <= figures_level:
                figures_level = 0
            if line.strip("# ").lower().startswith("figures"):
                figures_level = level
            section = _Section(line.strip("# "), figures_level > 0, [])
        else:
            section.lines.append(line)
    yield section
