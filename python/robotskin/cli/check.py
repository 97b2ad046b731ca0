# SPDX-License-Identifier: Apache-2.0
"""Name every defect of skin files, of any known format, or what their wiring can carry."""

import json
from collections import Counter
from pathlib import Path
from typing import Annotated, Any

import typer
from rich.markup import escape
from rich.table import Table

from robotskin.cli._terminal import terminal
from robotskin.cli._waiting import waiting
from robotskin.errors import InputError

SHOWN_PER_KIND = 3
STANDARD_RATE_HZ = 250.0

TABLE_WIDTH = 110
SHOWN_PARTS = 12


def command(
    files: Annotated[
        list[str], typer.Argument(help="Files, or folders of files; with --network finished layouts' names as well.")
    ],
    robot: Annotated[
        str | None, typer.Option(help="Check against this robot's meshes (a layout of this project names its own).")
    ] = None,
    show_all: Annotated[bool, typer.Option("--all", help="List every defect, not three of each kind.")] = False,
    json_file: Annotated[
        Path | None, typer.Option("--json", help="Write every defect to this file.", dir_okay=False)
    ] = None,
    strict: Annotated[bool, typer.Option(help="Exit with status 1 if there is any defect.")] = False,
    network: Annotated[
        bool, typer.Option("--network", help="Judge the wiring instead: rate, loads, depth, and what limits them.")
    ] = False,
    rate: Annotated[
        float | None,
        typer.Option(help="With --network: frames a second that each cell shall send; 250 by default.", min=1),
    ] = None,
    picture: Annotated[
        Path | None, typer.Option(help="With --network: draw trees, cut and loads into this file.", dir_okay=False)
    ] = None,
) -> None:
    """Name every defect of skin files, of any known format.

    Reads this project's layouts, TUM skin JSON and XML, iCub taxel files and URDF with tactile sensors; the content
    tells which. A file that is none of these is a defect as well, not a failure.

    With --network it names what the wiring can carry at the best, whatever the firmware does: which cables or bridges
    limit the rate, and where one more helps most. --strict then exits with status 1 if the rate is not reached.
    """
    from robotskin.layout.finished_layouts import finished_names
    from robotskin.outputs import PICTURES, require_writable

    foreign = {"--robot": robot, "--all": show_all} if network else {"--rate": rate, "--picture": picture}
    for option, value in foreign.items():
        if value:
            raise InputError(f"{option} {value}: is {'not ' if network else ''}for --network")
    require_writable("--json", json_file)
    require_writable("--picture", picture, PICTURES)
    known = finished_names() if network else ()
    for name in files:
        if name not in known and not Path(name).exists():
            also = "; robotskin cover ROBOT -o FILE makes one"
            if network:
                also = f", nor a finished layout: {', '.join(known)}"
            elif name in finished_names():
                also = f"; the wiring of that finished layout is judged by robotskin check --network {name}"
            raise InputError(f"{name}: there is no such file or folder{also}")
    if network:
        judge_networks(files, rate or STANDARD_RATE_HZ, picture, json_file, strict)
        return
    from robotskin.layout.checking import check_files

    console = terminal()
    if console.width < TABLE_WIDTH:
        console = terminal(TABLE_WIDTH)
    results = check_files([Path(file) for file in files], robot)
    summary = Table(title=f"{len(results)} file{'' if len(results) == 1 else 's'}")
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
                console.print(line, highlight=False, soft_wrap=True)
        for kind, count in kinds.items():
            if not show_all and count > SHOWN_PER_KIND:
                line = f"{result.file}: {count - SHOWN_PER_KIND} more {kind} (--all lists them)"
                console.print(line, highlight=False, soft_wrap=True)
    console.print(summary)
    if json_file is not None:
        document: list[dict[str, Any]] = [result.as_json() for result in results]
        json_file.write_text(json.dumps(document, indent=1) + "\n", encoding="utf-8")
    if strict and any(result.defects for result in results):
        raise typer.Exit(1)


def judge_networks(
    skins: list[str], rate_hz: float, picture: Path | None, json_file: Path | None, strict: bool
) -> None:
    """Tell what the wiring of each skin can carry: files, folders or names of finished layouts."""
    from robotskin.layout.network_limits import judge, named_networks, sentences
    from robotskin.layout.network_limits.picture import save_picture

    console = terminal()
    if console.width < TABLE_WIDTH:
        console = terminal(TABLE_WIDTH)
    verdicts = []
    for found in [network for skin in skins for network in named_networks(skin)]:
        with waiting(f"judging {found.source}"):
            verdict = judge(found.network, rate_hz)
        verdicts.append(verdict)
        console.print(f"{found.source}", style="bold", highlight=False)
        for line in (*(f"Note: {remark}." for remark in found.remarks), *sentences(verdict)):
            console.print(f"  {line}", highlight=False, soft_wrap=True)
        table = Table(title=f"{found.network.name}: the tightest of {len(verdict.parts)} connected parts")
        for heading in ("patches", "cells", "cables", "best loads", "proven", "Hz by trees", "Hz at most", "depth"):
            table.add_column(heading, justify="left" if heading == "patches" else "right", overflow="fold")
        for part in verdict.parts[:SHOWN_PARTS]:
            forest = part.forest
            patches = part.patches[0] + (f" and {len(part.patches) - 1} more" if len(part.patches) > 1 else "")
            depth = "-" if part.depth is None else str(part.depth)
            if part.even_depth is not None and part.even_depth != part.depth:
                depth += f" (even: {part.even_depth})"
            table.add_row(
                escape(patches),
                str(part.cells),
                str(part.cables),
                " ".join(str(load) for load in sorted(forest.loads, reverse=True)) if forest else "-",
                "yes" if forest and forest.proven else f"least {forest.bound}" if forest else "-",
                f"{part.tree_rate_hz:.0f}",
                f"{part.any_rate_hz:.0f}",
                depth,
            )
        console.print(table)
        if picture is not None:
            name = picture if len(verdicts) == 1 else picture.with_stem(f"{picture.stem}_{len(verdicts)}")
            save_picture(verdict, name)
            console.print(f"picture: {name}", highlight=False)
    if json_file is not None:
        json_file.write_text(json.dumps([verdict.as_json() for verdict in verdicts], indent=1) + "\n", encoding="utf-8")
    if strict and any(verdict.tree_rate_hz < rate_hz for verdict in verdicts):
        raise typer.Exit(1)
