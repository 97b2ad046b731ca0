# SPDX-License-Identifier: Apache-2.0
"""`robotskin export FILE`: a recording in the forms of others."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import Annotated

import typer

from robotskin.cli._waiting import waiting


def command(
    context: typer.Context,
    file: Annotated[Path, typer.Argument(help="A recording (MCAP) that `--record` or `robotskin record` has made.")],
    lerobot: Annotated[
        Path | None, typer.Option("--lerobot", help="Write a LeRobot data set, version 3, into this new folder.")
    ] = None,
    ros2: Annotated[
        Path | None, typer.Option("--ros2", help="Write a bag of ROS 2 (MCAP) into this new folder.")
    ] = None,
    foxglove: Annotated[
        Path | None, typer.Option("--foxglove", help="Write Foxglove's own messages into this new MCAP file.")
    ] = None,
    rrd: Annotated[Path | None, typer.Option("--rrd", help="Write this new file of Rerun.")] = None,
    fps: Annotated[int, typer.Option(help="Frames a second of --lerobot.", min=1, max=1000)] = 30,
    window: Annotated[int, typer.Option(help="Instants of force kept for each frame.", min=1, max=100)] = 5,
    task: Annotated[str, typer.Option(help="What the robot did, in words.")] = "touch",
) -> None:
    """Write a recording in the forms of others: data sets for robot learning, bags of ROS 2, files of viewers.

    Exit status 2: the file is damaged, what is to be written exists, or an extra is not installed.
    """
    from robotskin.apps.options import refuse_unless
    from robotskin.record import Recording

    if lerobot is None and ros2 is None and foxglove is None and rrd is None:
        raise typer.BadParameter("name at least one", param_hint="--lerobot, --ros2, --foxglove, --rrd")
    refuse_unless(lerobot is not None, context, "fps", "window", "task", because="is for --lerobot")
    recording = Recording(file)
    if lerobot is not None:
        from robotskin.export import export_lerobot

        with waiting("export") as tell:
            done = export_lerobot(
                recording, lerobot, fps=fps, window=window, task=task, tell=lambda share: tell("export", share)
            )
        typer.echo(f"{done['frames']} frames of {done['cells']} cells and {done['events']} events written to {lerobot}")
    for option, place in (("ros2", ros2), ("foxglove", foxglove), ("rrd", rrd)):
        if place is not None:
            export = exporter(option)
            with waiting("export") as tell:
                done = export(recording, place, tell=lambda share, tell=tell: tell("export", share))
            typer.echo(f"{', '.join(f'{count} {what}' for what, count in done.items())} written to {place}")
            if recording.unplayed_s:
                typer.echo(f"the last {recording.unplayed_s:.1f} s are left out: no keyframe leads there any more")


def exporter(option: str) -> Callable[..., dict[str, int]]:
    """What writes a form. Raises ExportFormatError where its extra is not installed."""
    from robotskin.export import ExportFormatError

    try:
        if option == "ros2":
            from robotskin.export.ros2_bag import export_ros2

            return export_ros2
        if option == "foxglove":
            from robotskin.export.foxglove_file import export_foxglove

            return export_foxglove
        from robotskin.export.rerun_file import export_rerun
    except ImportError as error:
        extra = "ros2" if option == "ros2" else "rerun"
        raise ExportFormatError(
            f"--{option}: {error.name} is not installed: pip install 'robotskin[{extra}]'"
        ) from error
    return export_rerun
