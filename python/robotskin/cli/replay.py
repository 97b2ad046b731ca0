# SPDX-License-Identifier: Apache-2.0
"""`robotskin replay FILE`: what a recording holds, through the shipping driver and skin reader."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from robotskin.cli._waiting import waiting
from robotskin.errors import InputError

if TYPE_CHECKING:
    from rich.console import Console

    from robotskin.record import Recording


def command(
    context: typer.Context,
    file: Annotated[Path, typer.Argument(help="A recording (MCAP) that `--record` or `robotskin record` has made.")],
    start: Annotated[float, typer.Option("--from", help="Begin so many seconds into it.", min=0)] = 0.0,
    end: Annotated[float | None, typer.Option("--to", help="End so many seconds into it; default: all of it.")] = None,
    csv: Annotated[
        Path | None, typer.Option("--csv", help="Write the samples here, a row a sample, SI units.", dir_okay=False)
    ] = None,
    html: Annotated[
        Path | None,
        typer.Option(
            "--html", help="Write the robot and its skin in motion here: a page that needs no server.", dir_okay=False
        ),
    ] = None,
    page: Annotated[
        bool, typer.Option("--page", help="Show it in the browser: play, pause, step, seek, until interrupted.")
    ] = False,
    port: Annotated[int, typer.Option(help="First port to try for the page, on 127.0.0.1.", min=1, max=65535)] = 8080,
    behaviour: Annotated[
        str | None,
        typer.Option(
            help="Step this behaviour's tasks with the recorded joints and skin, too, and tell how its commands differ."
        ),
    ] = None,
    fleet: Annotated[
        Path | None,
        typer.Option(
            "--fleet", metavar="FILE", help="Play it in real time as the robot of this file in a fleet.", dir_okay=False
        ),
    ] = None,
    json_file: Annotated[Path | None, typer.Option("--json", help="Write the figures here.", dir_okay=False)] = None,
) -> None:
    """Play a recording through the shipping driver and skin reader, and tell what was felt.

    Every skin state comes back to the byte. Exit status 2: the file is cut, damaged or foreign.
    """
    from rich.table import Table

    from robotskin.apps.options import refuse_unless
    from robotskin.cli._terminal import terminal
    from robotskin.figures import write_figures
    from robotskin.outputs import require_writable
    from robotskin.record import Recording
    from robotskin.record.summary import summarise

    for alone, asked in (("--page", page), ("--fleet", fleet is not None)):
        others = {"--to": end, "--csv": csv, "--html": html, "--json": json_file} | (
            {"--behaviour": behaviour, "--from": start or None, "--page": page or None} if alone == "--fleet" else {}
        )
        beside = [name for name, value in others.items() if value is not None]
        if asked and beside:
            raise InputError(f"{', '.join(beside)} with {alone}: only one at a time; give them without {alone}")
    refuse_unless(page, context, "port", because="is for --page")
    recording = Recording(file)
    if not start <= recording.seconds or (end is not None and not end >= start):
        raise InputError(
            f"--from {start:g}{'' if end is None else f' --to {end:g}'}: {file} lasts {recording.seconds:.1f} s; give "
            "a time within it, and an end behind it"
        )
    if page:
        serve(recording, port, behaviour, start)
        return
    if fleet is not None:
        from robotskin.cli._in_fleet import play_in_fleet

        play_in_fleet(recording, fleet)
        return
    if behaviour is not None:
        from robotskin import control

        control.behaviour(behaviour)  # refuses an unknown one before all is read
    until = float("inf") if end is None else end
    for option, target in (("--csv", csv), ("--html", html), ("--json", json_file)):
        require_writable(option, target)
    console = terminal()
    with waiting("replay") as tell:
        found = summarise(
            recording,
            start,
            until,
            lambda done: tell("replay", done / max(recording.seconds, 1e-9)),
        )
    about = recording.about
    console.print(
        f"{file}: {about['robot']}, {about['cells']} cells, {recording.seconds:.1f} s, recorded {about['started']} "
        f"by robotskin {about['robotskin']}",
        highlight=False,
        soft_wrap=True,
    )
    table = Table("link", "cells touched", "largest force of a cell", "felt for")
    for row in found.links:
        table.add_row(row.link, str(row.cells), f"{row.largest_n:.1f} N", f"{row.seconds:.2f} s")
    if found.links:
        console.print(table)
    elif not found.frames:
        console.print("no skin state can be replayed: no keyframe is in that time; --csv writes what samples there are")
    else:
        console.print("no cell felt more than 0.5 N")
    if found.unplayed_s:
        console.print(
            f"the last {found.unplayed_s:.1f} s cannot be replayed: something is missing, and no keyframe follows",
            highlight=False,
        )
    if found.gaps:
        console.print(
            f"{found.gaps} entries are missing, dropped while it was recorded or left out by --repair: the replay "
            "passes over that time"
        )
    fast = f", {found.speed:.1f} x real time" if found.seconds else ""
    console.print(f"{found.frames} skin state{'s' * (found.frames != 1)}{fast}", highlight=False)
    if behaviour is not None:
        compare(recording, behaviour, start, until, console)
    if csv is not None:
        recording.to_pandas(start, until).to_csv(csv, index=False)
        console.print(f"samples written to {csv}", highlight=False, soft_wrap=True)
    if html is not None:
        from robotskin.record.recorded_robot import recorded_robot
        from robotskin.viewer.exported_scene import scene_html
        from robotskin.viewer.recorded_scene import recorded_frames
        from robotskin.whole_file import whole_file

        with waiting("scene"):
            robot = recorded_robot(recording)
            text = scene_html(
                f"robotskin: {robot.name}", robot, recording.layout, recorded_frames(recording, start, until)
            )
        with whole_file(html) as partial:
            partial.write_text(text, encoding="utf-8")
        console.print(f"scene written to {html}: open it in a browser", highlight=False, soft_wrap=True)
    if json_file is not None:
        write_figures(json_file, int(about.get("seed", 0)), found.figures())


def compare(recording: Recording, behaviour: str, start_s: float, end_s: float, console: Console) -> None:
    """Print what a behaviour would have commanded beside what was commanded."""
    import numpy as np
    from rich.table import Table

    from robotskin.record.open_loop import MODES, UNITS, open_loop

    with waiting("tasks") as tell:
        found = open_loop(
            recording, behaviour, start_s, end_s, progress=lambda done: tell("tasks", done / recording.seconds)
        )
    by_clock, compared = np.count_nonzero(found.ended_by_clock), np.count_nonzero(found.compared)
    if by_clock:
        console.print(
            f"{by_clock} of {len(found.recorded)} ticks of the recording were ended by the clock; their commands "
            "cannot be compared",
            highlight=False,
            soft_wrap=True,
        )
    if not compared:
        return
    table = Table(f"joint ({found.mode.name})", "recorded commands vary by", f"{behaviour} differs by")
    for name, moved, difference in zip(found.joint_names, found.moved, found.difference, strict=True):
        table.add_row(name, f"{moved:.4f}", f"{difference:.4f}")
    console.print(table)
    console.print(
        f"{UNITS[MODES.index(found.mode)]}, root mean square of {compared} ticks; {found.speed:.1f} x real time. "
        f"Goal and fusion began at {found.begun_s:.1f} s. The joints are where they were, whatever is commanded.",
        highlight=False,
        soft_wrap=True,
    )


def serve(recording: Recording, port: int, behaviour: str | None = None, start_s: float = 0.0) -> None:
    """Serve the page of a recording from a time on until it is interrupted."""
    import threading

    from robotskin.live.replay import Replay
    from robotskin.viewer.replay_page import ReplayPage

    with waiting("reading what was felt"):
        replay, activity = Replay(recording, behaviour), recording.activity()
    title = f"{recording.about['robot']}, {recording.about['cells']} cells, {recording.path.name}"
    if start_s > 0:
        replay.seek(start_s)
    with replay, ReplayPage(replay, title, activity, port) as page:
        typer.echo(f"{title}: open {page.address} (Ctrl-C ends)")
        try:
            threading.Event().wait()
        except KeyboardInterrupt:
            typer.echo("closed")
