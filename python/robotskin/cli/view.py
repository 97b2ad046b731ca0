# SPDX-License-Identifier: Apache-2.0
"""`robotskin view ROBOT`: a robot in its skin and its living network, in the browser."""

import threading
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from robotskin.cli._ideal_processors import IdealProcessors
from robotskin.cli._sharing import Foxglove, tell, told_recorded
from robotskin.cli._waiting import waiting

if TYPE_CHECKING:
    from robotskin.layout import Layout
    from robotskin.robots import Robot


def command(
    robot: Annotated[str, typer.Argument(help="A robot by name, or the path of its URDF.")] = "ur5",
    layout: Annotated[
        Path | None, typer.Option(help="A layout file; by default the finished layout of that robot.", dir_okay=False)
    ] = None,
    network: Annotated[
        bool, typer.Option(help="Run the firmware of all cells, and draw the network as it lives.")
    ] = True,
    place: Annotated[
        bool, typer.Option("--place", help="Drag patches to where they sit, snap them to their link, save the layout.")
    ] = False,
    output: Annotated[
        Path | None,
        typer.Option(
            "--output",
            "-o",
            help="With --place, the file to save; by default --layout, else ROBOT.json.",
            dir_okay=False,
        ),
    ] = None,
    seed: Annotated[int, typer.Option(help="Of the network's wires and clocks.")] = 1,
    record: Annotated[
        Path | None,
        typer.Option(
            help="Keep what a host hears of the cells in this file (MCAP); nothing touches them. robotskin replay.",
            dir_okay=False,
        ),
    ] = None,
    foxglove: Foxglove = None,
    port: Annotated[int, typer.Option(help="First port to try, on 127.0.0.1.", min=1, max=65535)] = 8080,
    ideal_processors: IdealProcessors = False,
) -> None:
    """Show a robot in its skin in the browser: patches, cables and the living network, until interrupted.

    Every cell runs the shipping firmware. Click a wire or a plug to cut it, a cell to kill it, and watch the trees grow
    around the damage, as slowly as you like.
    """
    from contextlib import ExitStack

    if output is not None and not place:
        raise typer.BadParameter("is for --place", param_hint="--output")
    from robotskin import robots
    from robotskin.errors import InputError
    from robotskin.layout import Layout, finished
    from robotskin.live.live_network import LiveNetwork
    from robotskin.robots.gains import GainSet, robots_with_gains
    from robotskin.viewer.exhibit import Exhibit

    with waiting(f"loading {robot}"):
        model = robots.load(robot)
        skin = finished(model.name) if layout is None else Layout.load(layout)
    if record is not None and (place or not network or not skin.section_unit_ports):
        why = "--place" if place else "--no-network" if not network else "a layout without cables"
        raise InputError(f"--record {record} with {why}: no cell sends anything; robotskin run {robot} records, too")
    if place:
        serve_placing(model, skin, output or layout or Path(f"{model.name}.json"), port)
        return
    posture = GainSet.load(model.name).home if model.name in robots_with_gains() else None
    if posture is not None and len(posture) != model.joint_count:
        posture = None
    with ExitStack() as stack:
        with waiting("opening the page"):
            living = stack.enter_context(LiveNetwork(skin, seed)) if network and skin.section_unit_ports else None
            exhibit = stack.enter_context(Exhibit(model, skin, port, living, posture))
        if living is not None and record is not None:
            living.record(model, record)
        typer.echo(f"{model.name} with {len(skin)} cells: open {exhibit.address} (Ctrl-C ends)")
        if foxglove is not None:
            from robotskin.sharing.shown_network import ShownNetwork

            look = None if living is None else living.reading
            stack.enter_context(ShownNetwork(model, skin, foxglove, lambda: exhibit.posture, look, tell))
        try:
            threading.Event().wait()
        except KeyboardInterrupt:
            typer.echo("closed")
    if living is not None and living.host is not None and record is not None:
        told_recorded(record, living.host.recorder.dropped)


def serve_placing(robot: "Robot", layout: "Layout", path: Path, port: int) -> None:
    """Serve the page on which patches are placed until it is interrupted; what was not saved is told."""
    from robotskin.viewer.placing import PlacingPage

    with PlacingPage(robot, layout, path, port) as page:
        typer.echo(f"{robot.name}, {len(layout.patches)} patches, saved to {path}: open {page.address} (Ctrl-C ends)")
        try:
            threading.Event().wait()
        except KeyboardInterrupt:
            typer.echo("closed; changes were not saved" if page.history.unsaved else "closed")
