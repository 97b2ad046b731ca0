# SPDX-License-Identifier: Apache-2.0
"""The runs that are kept and the rows that are made from them, as `catalogue.toml` names them."""

from __future__ import annotations

import shlex
import tomllib
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

from robotskin.errors import RobotskinError, UnknownNameError

FILE = Path(__file__).with_name("catalogue.toml")


class CatalogueError(RobotskinError):
    """A row or a run of the catalogue that cannot be used; the message names it."""


@dataclass(frozen=True)
class Run:
    """One command whose figures are kept.

    command: without `robotskin`, without `--seed` and `--json`. quick: the same in a short form. seeds, quick_seeds:
    with each of these it is run. measures: the paths of the repository whose change makes the result old, those of the
    group that it goes `through` among them. minutes: of the whole form, about, on two cores.
    """

    name: str
    command: str
    quick: str
    seeds: tuple[int, ...]
    quick_seeds: tuple[int, ...]
    measures: tuple[str, ...]
    minutes: float

    def arguments(self, *, quick: bool) -> list[str]:
        """The words after `robotskin`."""
        return shlex.split(self.form(quick=quick))

    def form(self, *, quick: bool) -> str:
        """The command, whole or short."""
        return self.quick if quick else self.command

    def wanted_seeds(self, *, quick: bool) -> tuple[int, ...]:
        """Those of a whole result."""
        return self.quick_seeds if quick else self.seeds

    def lacking(self, seeds: Sequence[int], *, quick: bool) -> list[int]:
        """Those that a result of these seeds lacks."""
        return sorted(set(self.wanted_seeds(quick=quick)) - set(seeds))


@dataclass(frozen=True)
class Row:
    """One row of the table: what is stated, and how ours is said with the figures of a run.

    ours: a format string over the run's figures. worst: for each figure named here, `least` or `most` of the seeds
    counts, or their `mean` or `sum` where trials are pooled; `most` for those that are not named. ratio: a figure of
    the run and the stated number that divides it.
    """

    figure: str
    stated: str
    run: str
    ours: str
    worst: dict[str, str]
    ratio: tuple[str, float] | None


@dataclass(frozen=True)
class Lack:
    """What the paper states and this project does not have. ours: what stands in its place, or nothing."""

    figure: str
    stated: str
    ours: str


@dataclass(frozen=True)
class Difference:
    """What this project does otherwise by choice."""

    of: str
    paper: str
    ours: str


@dataclass(frozen=True)
class Catalogue:
    """All runs by name, all rows in their order."""

    runs: dict[str, Run]
    rows: tuple[Row, ...]
    lacks: tuple[Lack, ...] = ()
    differences: tuple[Difference, ...] = ()

    def chosen(self, names: Sequence[str]) -> list[Run]:
        """The runs with these names; all where none is named.

        Raises:
            UnknownNameError: no such run.
        """
        for name in names:
            if name not in self.runs:
                raise UnknownNameError("run", name, self.runs)
        return [self.runs[name] for name in names] or list(self.runs.values())


def read(file: Path = FILE) -> Catalogue:
    """The catalogue of a file.

    Raises:
        CatalogueError: a row names a run that is not there.
    """
    document = tomllib.loads(file.read_text(encoding="utf-8"))
    always = tuple(document["measures_always"])
    groups = document["measures_through"]
    runs = {
        name: Run(
            name,
            entry["command"],
            entry.get("quick", entry["command"]),
            tuple(entry.get("seeds", [1])),
            tuple(entry.get("quick_seeds", entry.get("seeds", [1])[:1])),
            (*(groups[entry["through"]] if "through" in entry else ()), *entry["measures"], *always),
            entry["minutes"],
        )
        for name, entry in document["run"].items()
    }
    rows = []
    for entry in document["row"]:
        if entry["run"] not in runs:
            raise CatalogueError(f"row {entry['figure']!r}: run {entry['run']!r} is none of {', '.join(sorted(runs))}")
        ratio = entry.get("ratio")
        rows.append(
            Row(
                entry["figure"],
                entry["stated"],
                entry["run"],
                entry["ours"],
                entry.get("worst", {}),
                (ratio[0], float(ratio[1])) if ratio else None,
            )
        )
    lacks = tuple(Lack(**entry) for entry in document["lack"])
    return Catalogue(runs, tuple(rows), lacks, tuple(Difference(**entry) for entry in document["difference"]))
