# SPDX-License-Identifier: Apache-2.0
"""Tables that programs write into pages: between the lines `<!-- NAME -->` and `<!-- end -->`."""

from __future__ import annotations

from collections.abc import Iterable

END = "<!-- end -->"


def _parted(page: str, name: str) -> tuple[str, str, str]:
    start = f"<!-- {name} -->\n"
    before, found, rest = page.partition(start)
    inside, ended, after = rest.partition(END)
    if not found or not ended:
        raise ValueError(f"the page has no table between the lines {start.strip()} and {END}")
    return before + start, inside, END + after


def rows_of(page: str, name: str) -> list[str]:
    """The rows of the table as the page has them, without the two lines of its head.

    Raises:
        ValueError: the page has no such table.
    """
    return _parted(page, name)[1].strip().splitlines()[2:]


def with_table(page: str, name: str, lines: Iterable[str]) -> str:
    """The page with these lines as the whole table.

    Raises:
        ValueError: the page has no such table.
    """
    before, _, after = _parted(page, name)
    return before + "".join(f"{line}\n" for line in lines) + after


def with_rows(page: str, name: str, rows: Iterable[str]) -> str:
    """The page with these rows below the two lines of head that the table has.

    Raises:
        ValueError: the page has no such table.
    """
    head = _parted(page, name)[1].strip().splitlines()[:2]
    return with_table(page, name, [*head, *rows])
