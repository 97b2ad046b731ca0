"""Name every defect of skin files, of any known format."""

import json
from collections import Counter
from pathlib import Path
from typing import Annotated, Any

import typer
from rich.console import Console
from rich.markup import escape
from rich.table import Table

SHOWN_PER_KIND = 3

TABLE_WIDTH = 110


def command(
    files: Annotated[list[Path], typer.Argument(help="Files, or folders of files.", exists=True)],
    robot: Annotated[
        str | None, typer.Option(help="Check against this robot's meshes (a layout of this project names its own).")
    ] = None,
    show_all: Annotated[bool, typer.Option("--all", help="List every defect, not three of each kind.")] = False,
    json_file: Annotated[
        Path | None, typer.Option("--json", help="Write every defect to this file.", dir_okay=False)
    ] = None,
    strict: Annotated[bool, typer.Option(help="Exit with status 1 if there is any defect.")] = False,
) -> None:
    """Name every defect of skin files, of any known format.

    Reads this project's layouts, TUM skin JSON and XML, iCub taxel files and URDF with tactile sensors; the content
    tells which. A file that is none of these is a defect as well, not a failure.
    """
    from robotskin.layout.checking import check_files

    console = Console()
    if console.width < TABLE_WIDTH:
        console = Console(width=TABLE_WIDTH)
    results = check_files(files, robot)
    summary = Table(title=f"{len(results)} files")
    for heading in ("file", "format", "cells", "empty slots", "defects"):
        summary.add_column(heading, justify="right" if heading in ("cells", "empty slots") else "left", overflow="fold")
    for result in results:
        kinds = Counter(defect.kind for defect in result.defects)
        told = ", ".join(f"{count} {kind}" for kind, count in kinds.most_common()) or "none"
        summary.add_row(escape(result.file), result.format, str(result.cells), str(result.empty), told)
        shown: Counter[str] = Counter()
        for defect in result.defects:
            shown[defect.kind] += 1
            if show_all or shown[defect.kind] <= SHOWN_PER_KIND:
                line = f"{result.file}: {defect.cell}: {defect.kind}: {defect.value}: {defect.why}"
                console.print(line, markup=False, highlight=False, soft_wrap=True)
        for kind, count in kinds.items():
            if not show_all and count > SHOWN_PER_KIND:
                line = f"{result.file}: {count - SHOWN_PER_KIND} more {kind} (--all lists them)"
                console.print(line, markup=False, highlight=False, soft_wrap=True)
    console.print(summary)
    if json_file is not None:
        document: list[dict[str, Any]] = [result.as_json() for result in results]
        json_file.write_text(json.dumps(document, indent=1) + "\n", encoding="utf-8")
    if strict and any(result.defects for result in results):
        raise typer.Exit(1)
