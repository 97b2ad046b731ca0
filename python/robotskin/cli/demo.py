# SPDX-License-Identifier: Apache-2.0
"""`robotskin demo`: a robot in its skin gives way to touch, in the browser or as a scripted test."""

from __future__ import annotations

import contextlib
import threading
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from robotskin.apps.options import Threads
from robotskin.cli._ideal import Ideal
from robotskin.cli._ideal_processors import IdealProcessors
from robotskin.cli._sharing import Fleet, Foxglove, Ros2, Ros2Commands, Ros2Interface, Sharing, shared
from robotskin.cli._waiting import waiting

if TYPE_CHECKING:
    from rich.console import Console

    from robotskin.layout import Layout
    from robotskin.robots import Robot
    from robotskin.session import Session


def command(
    context: typer.Context,
    robot: Annotated[str, typer.Option(help="A robot by name (robotskin robots lists them), or its URDF.")] = "ur5",
    gains: Annotated[
        Path | None,
        typer.Option(
            help="A gain file (robotskin gains writes one); by default the robot's own, or made on the spot.",
            exists=True,
            dir_okay=False,
        ),
    ] = None,
    layout: Annotated[
        Path | None,
        typer.Option(
            help="A layout file, or TUM patches to mount on --link; by default the robot's finished layout.",
            exists=True,
        ),
    ] = None,
    link: Annotated[
        str | None,
        typer.Option(
            help="The link that carries --layout, and whose cells the script pushes; by default one that gives "
            "way well."
        ),
    ] = None,
    headless: Annotated[bool, typer.Option("--headless", help="No page: run the script, measure, and end.")] = False,
    seconds: Annotated[
        float,
        typer.Option(
            help="Simulated seconds each interface gets at least with --headless; the script takes 32.", min=0
        ),
    ] = 20.0,
    seed: Annotated[int, typer.Option(help="Repeats the run.")] = 1,
    json_file: Annotated[Path | None, typer.Option("--json", help="Write the figures here.", dir_okay=False)] = None,
    interface: Annotated[str, typer.Option(help="position, velocity or torque.")] = "position",
    mode: Annotated[str, typer.Option(help="clock or event.")] = "clock",
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
    estimated_layout: Annotated[
        str,
        typer.Option(
            "--model",
            help="Where the controller takes the cells to be: true, configured (the skin finds itself first, which "
            "takes a minute), or a layout file such as robotskin configure writes.",
        ),
    ] = "true",
    threads: Threads = 1,
    ideal: Ideal = False,
    ideal_processors: IdealProcessors = False,
) -> None:
    """Run a skinned robot: cells, network, UDP, driver and controller are the real ones, links and body simulated.

    Exit status 0 means that every figure with a bound keeps it.
    """
    from robotskin import layout as layouts
    from robotskin.apps.options import refuse_in_page, refuse_unless
    from robotskin.cli._terminal import terminal
    from robotskin.cli.run import tell_gains
    from robotskin.layout.mounting import read_for
    from robotskin.outputs import require_writable
    from robotskin.robots.gains import robot_with_gains
    from robotskin.session import Session
    from robotskin.session.touches import link_to_push, require_cells_on
    from robotskin.world import load_scene

    require_writable("--json", json_file, (".json",))
    refuse_in_page(headless, context, "json_file", "seconds")
    refuse_unless(not headless, context, "ros2_commands", because="is for the page")
    because = "is for the page: the script of --headless measures every interface, by clock and by event"
    refuse_unless(not headless, context, "interface", "mode", because=because)
    around = None if scene is None else load_scene(scene)
    console = terminal()
    with waiting(f"loading {robot}"):
        ready = robot_with_gains(robot, gains)
        model = ready.robot
        skin = layouts.finished(model.name) if layout is None else read_for(model, layout, link, seed=seed)
        pushed = link or link_to_push(model, ready.gains, skin)
        require_cells_on(skin, pushed)
    tell_gains(console, ready, gains)
    estimated_skin, control = estimated_model(console, estimated_layout, model, skin, seed)
    if estimated_skin is not None:
        require_cells_on(estimated_skin, pushed)
    session = Session(
        model,
        skin,
        seed=seed,
        interface=interface,
        mode=mode,
        estimated_layout=estimated_skin,
        control=control,
        cell_torques=False if headless else None,
        scene=around,
        gains=ready.gains,
        threads=threads,
    )
    with shared(session, model, record, foxglove, ros2, ros2_interface, ros2_commands, fleet) as sharing:
        if headless:
            raise typer.Exit(run_script(session, pushed, seconds, json_file))
        raise typer.Exit(show(session, port, sharing=sharing))


def estimated_model(
    console: Console, estimated_layout: str, model: Robot, skin: Layout, seed: int
) -> tuple[Layout | None, Robot | None]:
    """Layout and robot that --model asks for, None for the true ones; a skin that is to find itself does so here."""
    if estimated_layout == "true":
        return None, None
    if estimated_layout != "configured":
        from robotskin.layout import Layout

        return Layout.load(estimated_layout), None
    from robotskin.configuring.configured import configured

    with waiting("waking the skin") as tell:
        own = configured(model, skin, seed, tell)
    heard = len(own.configuration.topology.cell)
    console.print(f"the skin placed {len(own.layout)} of its {heard} cells after {own.duration_s:.0f} s of motion")
    return own.layout, own.robot


def run_script(session: Session, link: str, seconds: float, json_file: Path | None) -> int:
    """Run the scripted demonstration, print its table, write its figures; the exit status."""
    from robotskin.cli._terminal import terminal
    from robotskin.figures import report
    from robotskin.scripts import push_script

    console = terminal()
    try:
        with waiting("boot") as tell:
            figures = push_script.run(session, link, seconds, tell)
    finally:
        session.shut_down()
    bounds = push_script.bounds(figures, session.interfaces)
    title = f"{session.robot.name}, {len(session.layout)} cells"
    return report(
        console,
        title,
        figures,
        bounds,
        session.seed,
        json_file,
        [*push_script.remarks(session, figures), session.fault_told],
    )


def show(session: Session, port: int, goal: list[float] | None = None, sharing: Sharing | None = None) -> int:
    """Serve the page until it is interrupted, tell what held the robot back; the exit status.

    `goal`: where the robot goes first, as `robotskin run --goal` takes it.
    """
    from robotskin.apps.balance.panel import BalancePage
    from robotskin.cli._terminal import terminal
    from robotskin.live.live_session import LiveSession
    from robotskin.session.goals import set_goal

    console = terminal()
    try:
        with waiting("booting the skin"):
            took_s = session.boot()
        place = None if goal is None else set_goal(session, goal)
    except BaseException:  # From here to the page's own thread nothing else would stop the robot.
        session.shut_down()
        raise
    console.print(f"{len(session.layout)} cells alive after {took_s:.2f} s of simulated time")
    with contextlib.ExitStack() as stack:
        live = stack.enter_context(LiveSession(session, place))
        page = stack.enter_context(BalancePage(live, port))
        if sharing is not None:
            stack.enter_context(sharing.heed(live))
        console.print(f"open [bold]{page.address}[/] (Ctrl-C ends)", markup=True)
        try:
            threading.Event().wait()
        except KeyboardInterrupt:
            console.print("bringing the robot to rest")
    for remark in live.remarks():
        console.print(remark, highlight=False, soft_wrap=True)
    return 1 if session.fault or live.failure is not None else 0
