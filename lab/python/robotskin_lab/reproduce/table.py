# SPDX-License-Identifier: Apache-2.0
"""The tables of docs/reproduction.md: figures, made from the kept results, and what differs by choice."""

from __future__ import annotations

import re
from pathlib import Path

from robotskin_lab import page_table
from robotskin_lab.reproduce.catalogue import Catalogue, Row
from robotskin_lab.reproduce.cited import with_figures
from robotskin_lab.reproduce.result import FOLDER, TREE, Result, ResultError, is_old, load

PAGE = TREE / "docs" / "reproduction.md"
PAGES = sorted([*TREE.glob("*.md"), *(TREE / "docs").rglob("*.md")])
OLD = " (older than the code)"
COUNT = re.compile(r"<!-- older -->.*?<!-- end older -->")
"""How many rows are so, in the text of the page."""
HEAD = (
    "| figure | stated (or our rebuild of the method) | ours | ours / stated | measured by | at commit |",
    "|---|---|---|---|---|---|",
)
DIFFERENCES_HEAD = ("| of | the paper | this project |", "|---|---|---|")


def said(row: Row, result: Result) -> tuple[str, str]:
    """What the row says of ours, and its ratio to what is stated.

    Raises:
        ResultError: the row names a figure that the result has not.
    """
    figures = result.worst(row.worst)
    try:
        ours = row.ours.format(**figures)
        ratio = "—" if row.ratio is None else f"{figures[row.ratio[0]] / row.ratio[1]:.2g}"
    except KeyError as missing:
        raise ResultError(
            f"row {row.figure!r}: {missing.args[0]} is no figure of {result.run}.json; measure it anew "
            f"(`robotskin reproduce {result.run}`) or mend catalogue.toml"
        ) from None
    return ours, ratio


def line(row: Row, catalogue: Catalogue, folder: Path = FOLDER) -> str:
    """One line of the table; a row whose run was never made says so."""
    run = catalogue.runs[row.run]
    try:
        result = load(row.run, folder)
    except ResultError:
        return f"| {row.figure} | {row.stated} | not measured yet | — | `robotskin {run.command}` | — |"
    ours, ratio = said(row, result)
    seeds = f"{len(result.seeds)} seeds" if len(result.seeds) > 1 else f"seed {result.seeds[0]}"
    if run.lacking(result.seeds, quick=result.quick):
        seeds = f"{len(result.seeds)} of {len(run.wanted_seeds(quick=result.quick))} seeds"
    form = " (short form)" if result.quick else ""
    old = OLD if is_old(result, run) else ""
    command = f"`robotskin {result.command}`{form}"
    return f"| {row.figure} | {row.stated} | {ours} | {ratio} | {command}, {seeds} | {result.commit}{old} |"


def lines(catalogue: Catalogue, folder: Path = FOLDER) -> list[str]:
    """The whole table of figures, its head first; what is not reproduced stands last."""
    lacks = (f"| {lack.figure} | {lack.stated} | {lack.ours} | — | — | — |" for lack in catalogue.lacks)
    return [*HEAD, *(line(row, catalogue, folder) for row in catalogue.rows), *lacks]


def differences(catalogue: Catalogue) -> list[str]:
    """The table of what differs by choice, its head first."""
    return [*DIFFERENCES_HEAD, *(f"| {one.of} | {one.paper} | {one.ours} |" for one in catalogue.differences)]


def with_table(page: str, catalogue: Catalogue) -> str:
    """The page with both tables as they should be, and how many rows are marked as old."""
    rows = lines(catalogue)
    page = page_table.with_table(page, "results", rows)
    page = page_table.with_table(page, "differences", differences(catalogue))
    old = sum(OLD in row for row in rows)
    return COUNT.sub(f"<!-- older -->{old} of {len(catalogue.rows)}<!-- end older -->", page)


def write(catalogue: Catalogue) -> list[Path]:
    """Write the table into its page, and the cited figures into every page; return the pages that changed."""
    changed = []
    for page in PAGES:
        before = page.read_text(encoding="utf-8")
        after = with_figures(with_table(before, catalogue) if page == PAGE else before)
        if after != before:
            page.write_text(after, encoding="utf-8")
            changed.append(page)
    return changed
