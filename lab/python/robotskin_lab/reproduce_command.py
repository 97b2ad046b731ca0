# SPDX-License-Identifier: Apache-2.0
"""`robotskin reproduce`: measure what the pages state, keep the results, write the table that is made from them."""

from __future__ import annotations

from typing import Annotated

import typer
from rich.console import Console
from rich.table import Table

from robotskin_lab.executors import Executor, named
from robotskin_lab.executors.named import HELP
from robotskin_lab.reproduce import catalogue as catalogues
from robotskin_lab.reproduce import table
from robotskin_lab.reproduce.catalogue import Catalogue, Run
from robotskin_lab.reproduce.cited import unstored
from robotskin_lab.reproduce.measure import RunFailedError, measure
from robotskin_lab.reproduce.result import TREE, ResultError, folder_for, is_old, load

console = Console()


def command(
    runs: Annotated[list[str] | None, typer.Argument(help="Runs of the catalogue; all by default.")] = None,
    quick: Annotated[
        bool,
        typer.Option(
            help="Each in its short form, which replaces no whole result; the table tells which rows are short."
        ),
    ] = False,
    listing: Annotated[
        bool, typer.Option("--list", help="List the runs with what they cost, and measure none.")
    ] = False,
    stale: Annotated[
        bool,
        typer.Option(
            help="List the results that are older than the code they measure, lack seeds or are of a short form; "
            "status 1 if any is."
        ),
    ] = False,
    more_seeds: Annotated[
        int | None,
        typer.Option(
            help="A long run in parts: measure at most so many seeds that are missing, and keep them with those "
            "before, where the sources are the same. By default all.",
            min=0,
        ),
    ] = None,
    on: Annotated[str, typer.Option(help=f"{HELP} Times are truest one after the other.")] = "here",
    only_table: Annotated[bool, typer.Option("--table", help="Write the table from the kept results only.")] = False,
) -> None:
    """Measure the figures of docs/reproduction.md again, keep them under docs/results, and write the table."""
    catalogue = catalogues.read()
    chosen = catalogue.chosen(runs or [])
    if listing:
        _list(chosen, quick=quick)
        return
    if stale:
        raise typer.Exit(_tell_stale(chosen))
    if not only_table:
        failed = _measure(chosen, named(on), quick=quick, more_seeds=more_seeds)
        _write(catalogue)
        raise typer.Exit(int(failed))
    _write(catalogue)


def _write(catalogue: Catalogue) -> None:
    for page in table.write(catalogue):
        console.print(f"wrote {page}")


def _measure(chosen: list[Run], executor: Executor, *, quick: bool, more_seeds: int | None) -> bool:
    """Measure each; a run that fails is told, the others go on. Whether any failed."""
    failed = False
    minutes = "" if quick else f", about {sum(run.minutes for run in chosen):g} min on one machine"
    console.print(f"[bold]{', '.join(run.name for run in chosen)}[/]{minutes}")

    def tell(line: str) -> None:
        console.print(f"  {line}", highlight=False)

    for result in measure(chosen, executor, quick=quick, more_seeds=more_seeds, tell=tell):
        if isinstance(result, RunFailedError):
            console.print(f"[red]{result}[/]")
            failed = True
        else:
            console.print(f"  kept in {result.save(folder_for(result))}")
    return failed


def _list(chosen: list[Run], *, quick: bool) -> None:
    told = Table("run", "command", "seeds", "minutes")
    for run in chosen:
        seeds = ", ".join(map(str, run.wanted_seeds(quick=quick)))
        minutes = "a few" if quick else f"{run.minutes:g}"
        told.add_row(run.name, f"robotskin {run.form(quick=quick)}", seeds, minutes)
    console.print(told)


def _tell_stale(chosen: list[Run]) -> int:
    """Print what is old or missing; 1 if anything is."""
    old = Table("run", "kept at", "what is wrong", "next")
    for run in chosen:
        try:
            result = load(run.name)
        except ResultError:
            old.add_row(run.name, "—", "never measured", f"robotskin reproduce {run.name}")
            continue
        if is_old(result, run):
            old.add_row(run.name, result.commit, "older than the code", f"robotskin reproduce {run.name}")
        elif missing := run.lacking(result.seeds, quick=result.quick):
            lacks = f"lacks {len(missing)} of {len(missing) + len(result.seeds)} seeds"
            old.add_row(run.name, result.commit, lacks, f"robotskin reproduce {run.name}")
        elif result.quick:
            old.add_row(run.name, result.commit, "short form", f"robotskin reproduce {run.name}")
    console.print(old if old.row_count else "every kept result is of the code as it is")
    for page in table.PAGES:
        for heading in unstored(page.read_text(encoding="utf-8")):
            console.print(f"{page.relative_to(TREE)}, {heading}: figures of no stored result", highlight=False)
    return int(old.row_count > 0)
