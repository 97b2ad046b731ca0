# SPDX-License-Identifier: Apache-2.0
"""`robotskin record FILE`: a robot is touched at random and all of it is kept; or a file that was cut is mended."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer


def command(
    context: typer.Context,
    file: Annotated[Path, typer.Argument(help="The recording (MCAP); Foxglove opens it, robotskin replay plays it.")],
    repair: Annotated[bool, typer.Option("--repair", help="Mend FILE, which was cut or damaged.")] = False,
    robot: Annotated[str, typer.Option(help="A robot by name (robotskin robots lists them), or its URDF.")] = "ur5",
    behaviour: Annotated[str, typer.Option(help="What it does, as of robotskin run.")] = "skin_compliance",
    mode: Annotated[str, typer.Option(help="clock or event: how the cells send.")] = "clock",
    seconds: Annotated[float, typer.Option(help="Simulated seconds of touches.", min=0)] = 10.0,
    seed: Annotated[int, typer.Option(help="Repeats the run.")] = 1,
) -> None:
    """Record a robot that is touched at random, or mend a recording with --repair.

    `demo`, `run` and `connect` record as well, with --record FILE. Exit status 2: the file cannot be written or mended.
    """
    from robotskin.apps.options import refuse_unless

    because = "with --repair: nothing is recorded"
    refuse_unless(not repair, context, "robot", "behaviour", "mode", "seconds", "seed", because=because)
    if repair:
        mend(file)
        return
    from robotskin.cli.run import command as run

    run(context, robot, behaviour, headless=True, seconds=seconds, mode=mode, seed=seed, record=file)


def mend(file: Path) -> None:
    """Mend a file in its place and tell what was found."""
    from robotskin.record import repair

    found = repair(file)
    if found.was_whole:
        typer.echo(f"{file} is whole: {found.messages} messages, nothing to mend")
    else:
        left_out = f", {found.damaged_chunks} damaged chunks left out" if found.damaged_chunks else ""
        typer.echo(
            f"{file} is mended: {found.messages} messages up to {found.newest_ns / 1e9:.2f} s{left_out}; "
            "replay plays it"
        )
