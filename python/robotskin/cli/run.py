# SPDX-License-Identifier: Apache-2.0
"""`robotskin run`: a robot does one of the behaviours of the paper, in the browser or as a scripted test."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from robotskin.apps.options import SelfCollision, Threads
from robotskin.cli._ideal import Ideal
from robotskin.cli._ideal_processors import IdealProcessors
from robotskin.cli._sharing import Fleet, Foxglove, Ros2, Ros2Commands, Ros2Interface, shared
from robotskin.cli._waiting import waiting

if TYPE_CHECKING:
    from rich.console import Console

    from robotskin.robots.gains import RobotWithGains


def command(
    context: typer.Context,
    robot: Annotated[
        str,
        typer.Argument(help="A robot by name (robotskin robots lists them), or the path of its URDF."),
    ],
    behaviour: Annotated[
        str,
        typer.Option(help="A name, such as skin_compliance or kinesthetic_joint; a wrong one tells all."),
    ] = "skin_compliance",
    interface: Annotated[str, typer.Option(help="position, velocity or torque.")] = "position",
    fusion: Annotated[
        str | None,
        typer.Option(help="weighted_sum, null_space, null_space_at_rest or quadratic; default: the behaviour's own."),
    ] = None,
    goal: Annotated[
        str | None,
        typer.Option(help="Numbers with commas: rad for every joint, or metres x,y,z by which the hand is to move."),
    ] = None,
    headless: Annotated[bool, typer.Option("--headless", help="No page: touch at random, measure, and end.")] = False,
    seconds: Annotated[float, typer.Option(help="Simulated seconds of touches with --headless.", min=0)] = 10.0,
    layout: Annotated[
        Path | None,
        typer.Option(help="A layout file; by default the robot's finished layout.", exists=True, dir_okay=False),
    ] = None,
    calibration: Annotated[
        Path | None,
        typer.Option(
            help="A calibration of the skin's force sensors (robotskin calibrate).", exists=True, dir_okay=False
        ),
    ] = None,
    gains: Annotated[
        Path | None,
        typer.Option(
            help="A gain file (TOML, robotskin gains writes one); by default the robot's own, or made on the spot.",
            exists=True,
            dir_okay=False,
        ),
    ] = None,
    seed: Annotated[int, typer.Option(help="Repeats the run.")] = 1,
    mode: Annotated[str, typer.Option(help="clock or event.")] = "clock",
    skin_source: Annotated[
        str,
        typer.Option(help="What sums the torque of the skin task: host, or skin: the cells themselves."),
    ] = "host",
    self_collision: SelfCollision = False,
    skin_map: Annotated[
        Path | None,
        typer.Option(
            "--skin-map",
            help="React to touch by this map (robotskin configure --map FILE); recalling it needs no kinematic model.",
            exists=True,
            dir_okay=False,
        ),
    ] = None,
    body_limits: Annotated[
        Path | None,
        typer.Option(
            "--body-limits",
            help="Limits of contact by body region (TOML), at which the robot stops; docs/control.md.",
            exists=True,
            dir_okay=False,
        ),
    ] = None,
    fault_file: Annotated[
        Path, typer.Option("--fault-file", help="Where a fault leaves the last second of states (CSV).", dir_okay=False)
    ] = Path("robotskin_fault.csv"),
    json_file: Annotated[Path | None, typer.Option("--json", help="Write the figures here.", dir_okay=False)] = None,
    scene: Annotated[
        str | None, typer.Option(help="Things around the robot: a name of `robotskin scenes`, or a TOML file.")
    ] = None,
    record: Annotated[
        Path | None,
        typer.Option(help="Keep all that is felt and done in this file (MCAP); robotskin replay.", dir_okay=False),
    ] = None,
    foxglove: Foxglove = None,
    ros2: Ros2 = None,
    ros2_interface: Ros2Interface = None,
    ros2_commands: Ros2Commands = False,
    fleet: Fleet = None,
    port: Annotated[int, typer.Option(help="First port to try for the page, on 127.0.0.1.", min=1, max=65535)] = 8080,
    threads: Threads = 1,
    ideal: Ideal = False,
    ideal_processors: IdealProcessors = False,
) -> None:
    """Run a behaviour on a skinned robot: everything between contact and motor command is real, the two ends simulated.

    Exit status 0 means that the controller never stopped and no limit was violated.
    """
    from robotskin import control
    from robotskin import layout as layouts
    from robotskin.apps.options import refuse_in_page, refuse_unless
    from robotskin.calibration import Calibration
    from robotskin.choices import member
    from robotskin.cli._terminal import terminal
    from robotskin.control.body_limits import BodyLimits
    from robotskin.cycle import SkinSource
    from robotskin.outputs import require_writable
    from robotskin.robots.gains import robot_with_gains
    from robotskin.selfconfig.map.sensory_motor_map import SensoryMotorMap
    from robotskin.session import Session
    from robotskin.tasks import Fusion
    from robotskin.world import load_scene

    require_writable("--json", json_file, (".json",))
    refuse_in_page(headless, context, "json_file", "seconds")
    refuse_unless(not headless, context, "ros2_commands", because="is for the page")
    control.behaviour(behaviour)
    fused = None if fusion is None else member("fusion", Fusion, fusion)
    source = member("skin source", SkinSource, skin_source)
    target = numbers_of(goal)
    around = None if scene is None else load_scene(scene)
    learnt = None if skin_map is None else SensoryMotorMap.load(skin_map)
    limits = None if body_limits is None else BodyLimits.load(body_limits)
    console = terminal()
    with waiting(f"loading {robot}"):
        ready = robot_with_gains(robot, gains)
        model, chosen = ready.robot, ready.gains
        skin = layouts.finished(model.name) if layout is None else layouts.Layout.load(layout)
        if calibration is not None:
            skin = Calibration.load(calibration).applied(skin)
        session = Session(
            model,
            skin,
            behaviour,
            seed=seed,
            interface=interface,
            mode=mode,
            fusion=fused,
            cell_torques=True if source is SkinSource.skin else (False if headless else None),
            self_collision=self_collision,
            skin_map=learnt,
            body_limits=limits,
            fault_file=fault_file,
            gains=chosen,
            scene=around,
            threads=threads,
        )
        session.set_source(source)
    tell_gains(console, ready, gains)
    with shared(session, model, record, foxglove, ros2, ros2_interface, ros2_commands, fleet) as sharing:
        if headless:
            raise typer.Exit(run_script(session, seconds, target, json_file))
        from robotskin.cli.demo import show

        status = show(session, port, target, sharing)
    if session.fault:
        console.print(session.fault_told)
    raise typer.Exit(status)


def tell_gains(console: Console, ready: RobotWithGains, gains_file: Path | None) -> None:
    """Say so where gains were made on the spot, and what speaks against those of a file."""
    from robotskin.robots.gains.doubts import doubts

    for doubt in doubts(ready.robot, ready.gains) if gains_file is not None else ():
        console.print(f"--gains {gains_file}: {doubt}", highlight=False, soft_wrap=True)
    if ready.made:
        locked = f", with {', '.join(ready.gains.locked)} locked" if ready.gains.locked else ""
        console.print(
            f"gains of {ready.robot.name} made from {ready.source}{locked}; "
            f"robotskin gains {ready.robot.name} writes them",
            highlight=False,
            soft_wrap=True,
        )


def numbers_of(text: str | None, option: str = "--goal") -> list[float] | None:
    """The numbers of an option. Raises InputError for what is none."""
    from robotskin.errors import InputError

    if text is None:
        return None
    try:
        return [float(part) for part in text.split(",")]
    except ValueError:
        raise InputError(f"{option} {text}: must be numbers with commas between them") from None


def run_script(session: object, seconds: float, goal: list[float] | None, json_file: Path | None) -> int:
    """Run the script, print its table, write its figures; the exit status."""
    from robotskin.cli._terminal import terminal
    from robotskin.figures import report
    from robotskin.scripts import behaviour_script
    from robotskin.session import Session

    assert isinstance(session, Session)
    console = terminal()
    try:
        with waiting("boot") as tell:
            figures = behaviour_script.run(session, seconds, goal, tell)
            remarks = behaviour_script.remarks(session, figures, goal)
    finally:
        session.shut_down()
    bounds = behaviour_script.bounds()
    title = f"{session.robot.name}, {session.controller.behaviour.name}, {session.interface}"
    bounds = [bound for bound in bounds if bound.figure in figures or "goal" not in bound.figure]
    return report(console, title, figures, bounds, session.seed, json_file, [*remarks, session.fault_told])
