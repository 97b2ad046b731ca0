# SPDX-License-Identifier: Apache-2.0
"""Figures in the running text of pages: each between two comments that name its run, its key and its format.

    recovers within <!-- network.recovery_p50_ms .1f -->3.2<!-- --> ms

The comments are not shown. `robotskin reproduce --table` writes what stands between them.
"""

from __future__ import annotations

import re
from pathlib import Path

from robotskin_lab.reproduce.result import FOLDER, Result, ResultError, load

CITED = re.compile(r"<!-- (?P<run>[a-z]\w*)\.(?P<key>\w+) (?P<format>[^\s-]\S*) -->(?P<said>[^<]*)<!-- -->")


def figure(cited: re.Match[str], folder: Path = FOLDER) -> str:
    """What should stand between the comments: the worst of the seeds, the least where the format begins with `least:`.

    Raises:
        ResultError: no such result is kept, or it has no such figure.
    """
    result: Result = load(cited["run"], folder)
    way, _, form = cited["format"].rpartition(":")
    values = result.worst({cited["key"]: way})
    if cited["key"] not in values:
        raise ResultError(f"{cited[0]}: {result.run}.json has no figure {cited['key']!r}")
    return format(values[cited["key"]], form)


def with_figures(page: str, folder: Path = FOLDER) -> str:
    """The page with every cited figure as the kept results have it."""
    return CITED.sub(
        lambda cited: f"<!-- {cited['run']}.{cited['key']} {cited['format']} -->{figure(cited, folder)}<!-- -->", page
    )


def uncited(page: str) -> list[str]:
    """The lines in sections called Figures that say a number with a fraction or a unit and cite no result."""
    found, inside, fenced = [], False, False
    for line in page.splitlines():
        if line.startswith("```"):
            fenced = not fenced
        elif line.startswith("#"):
            inside = line.strip("# ").lower().startswith("figures")
        elif inside and not fenced and _NUMBER.search(CITED.sub("", line)):
            found.append(line)
    return found


_NUMBER = re.compile(r"(?<![\w.`(])\d+(?:[.,]\d+| ?(?:%|ms|µs|mm|°|N|s)\b)")
