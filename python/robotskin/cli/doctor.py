# SPDX-License-Identifier: Apache-2.0
"""`robotskin doctor ROBOT|FILE`: which cells of a skin are ill, and what to do about it."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from robotskin.cli._ideal import Ideal
from robotskin.cli._waiting import waiting

if TYPE_CHECKING:
    from robotskin.health import Finding
    from robotskin.layout import Layout
    from robotskin.robots import Robot


def command(
    what: Annotated[str, typer.Argument(help="A robot by name, which then works for a while, or a recording (MCAP).")],
    seconds: Annotated[float, typer.Option(help="How long a robot works, simulated seconds.", min=5)] = 60.0,
    ill: Annotated[
        int, typer.Option(help="Let so many cells of the simulated skin fall ill, to see them found.", min=0)
    ] = 0,
    presses: Annotated[
        Path | None,
        typer.Option(
            help="Instead of work, a table of touches of known force or with joint torques (CSV, docs/calibration.md): "
            "judges the gains of the force sensors.",
            exists=True,
            dir_okay=False,
        ),
    ] = None,
    seed: Annotated[int, typer.Option(help="Repeats the run.")] = 1,
    picture: Annotated[
        Path | None, typer.Option(help="Draw the robot with its ill cells here (PNG).", dir_okay=False)
    ] = None,
    json_file: Annotated[Path | None, typer.Option("--json", help="Write the figures here.", dir_okay=False)] = None,
    ideal: Ideal = False,
) -> None:
    """Name the cells that are dead, stuck, noisy, drifting or otherwise ill, from ordinary work or a recording.

    Exit status 0: every cell is well. 1: some are ill.
    """
    from robotskin.cli._terminal import terminal
    from robotskin.errors import InputError
    from robotskin.figures import write_figures
    from robotskin.health import report
    from robotskin.outputs import require_writable

    require_writable("--json", json_file, (".json",))
    require_writable("--picture", picture, (".png",))
    console = terminal()
    layout: Layout
    robot: Robot | None
    if presses is not None:
        layout, robot, findings, count = touched(what, presses)
        watched_s, from_what = 0.0, f"the gains of the force sensors of {count} touched cells are well"
    else:
        is_file = Path(what).suffix == ".mcap"
        if is_file and ill:
            raise InputError(f"--ill {ill}: cells of a recording cannot fall ill; give a robot, or leave --ill out")
        layout, robot, findings, watched_s = recorded(Path(what)) if is_file else worked(what, seconds, ill, seed)
        from_what = f"all {len(layout)} cells are well, as far as {watched_s:.0f} s tell"
    if findings:
        console.print(report.table(layout, findings))
    else:
        console.print(from_what, highlight=False)
    if picture is not None and robot is not None:
        report.save_picture(layout, robot, findings, picture)
        console.print(f"picture written to {picture}", highlight=False, soft_wrap=True)
    if json_file is not None:
        write_figures(json_file, seed, report.figures(layout, findings, watched_s))
    raise typer.Exit(1 if findings else 0)


def recorded(file: Path) -> tuple[Layout, Robot | None, list[Finding], float]:
    """What a recording shows."""
    from robotskin.health import HealthWatch
    from robotskin.record import Recording
    from robotskin.record.recorded_robot import recorded_robot

    recording = Recording(file)
    with waiting("replay") as tell:
        robot = recorded_robot(recording)
        watch = HealthWatch(recording.layout.skin_model(), robot.core, layout=recording.layout)
        for frame in recording.frames():
            known = len(frame.position) == robot.joint_count
            position, velocity = (frame.position, frame.velocity) if known else (None, None)
            if watch.tick(frame.time_ns, frame.skin, position, velocity, frame.measured_force):
                tell("replay", watch.seconds / max(recording.seconds, 1e-9))
    return recording.layout, robot, watch.findings, float(watch.seconds)


def touched(name: str, presses: Path) -> tuple[Layout, Robot, list[Finding], int]:
    """What touches of known force or with joint torques show, and how many cells were touched."""
    from robotskin import layout as layouts
    from robotskin.calibration import Known
    from robotskin.calibration.press_files import read_presses
    from robotskin.calibration.wrong_gains import wrong_gains
    from robotskin.cli.calibrate import FRICTION, friction_of
    from robotskin.robots.gains import robot_with_gains

    with waiting(f"loading {name}"):
        robot = robot_with_gains(name, None).robot
        layout = layouts.finished(robot.name)
        read = read_presses(presses, robot, layout)
        findings = wrong_gains(read, Known(friction_nm=friction_of(robot, FRICTION)))
    return layout, robot, findings, len(read)


def worked(name: str, seconds: float, ill: int, seed: int) -> tuple[Layout, Robot, list[Finding], float]:
    """What a simulated robot shows while it works."""
    from robotskin import layout as layouts
    from robotskin.health import work
    from robotskin.health.falling_ill import fall_ill
    from robotskin.robots.gains import robot_with_gains
    from robotskin.session import Session

    with waiting(f"loading {name}") as tell:
        ready = robot_with_gains(name, None)
        layout = layouts.finished(ready.robot.name)
        session = Session(ready.robot, layout, work.BEHAVIOUR, seed=seed, gains=ready.gains, link="in process")
        tell("boot")
        session.boot()
        fell = fall_ill(session, ill)
        findings = work.watched(session, seconds, lambda share: tell("at work", share))
        session.shut_down()
    if fell:
        typer.echo("made ill: " + ", ".join(f"{cell} {kind.title}" for cell, kind in sorted(fell.items())))
    return layout, ready.robot, findings, seconds
