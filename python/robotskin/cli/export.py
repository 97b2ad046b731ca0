# SPDX-License-Identifier: Apache-2.0
"""`robotskin export FILE --lerobot DIR`: a recording in the form of others."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from robotskin.cli._waiting import waiting


def command(
    file: Annotated[Path, typer.Argument(help="A recording (MCAP) that `--record` or `robotskin record` has made.")],
    lerobot: Annotated[
        Path, typer.Option("--lerobot", help="Write a LeRobot data set, version 3, into this new folder.")
    ],
    fps: Annotated[int, typer.Option(help="Frames a second.", min=1, max=1000)] = 30,
    window: Annotated[int, typer.Option(help="Instants of force kept for each frame.", min=1, max=100)] = 5,
    task: Annotated[str, typer.Option(help="What the robot did, in words.")] = "touch",
) -> None:
    """Write a recording as a data set for robot learning; every event of the skin stands in a table beside the frames.

    Exit status 2: the file is damaged, or the folder exists.
    """
    from robotskin.export import export_lerobot
    from robotskin.record import Recording

    recording = Recording(file)
    with waiting("export") as tell:
        done = export_lerobot(
            recording, lerobot, fps=fps, window=window, task=task, tell=lambda share: tell("export", share)
        )
    typer.echo(f"{done['frames']} frames of {done['cells']} cells and {done['events']} events written to {lerobot}")
