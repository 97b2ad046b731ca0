# SPDX-License-Identifier: Apache-2.0
"""`robotskin connect`: driver, skin, behaviours and page on section units and a robot that are really there."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from robotskin.cli._sharing import Fleet, Foxglove, Ros2, Ros2Commands, Ros2Interface, Sharing, shared
from robotskin.cli._waiting import waiting

if TYPE_CHECKING:
    from robotskin.connecting import ConnectedRobot, ConnectedSkin, TouchOrder
    from robotskin.layout import Layout


def command(
    context: typer.Context,
    robot: Annotated[str, typer.Argument(help="A robot by name (robotskin robots lists them), or its URDF.")],
    robot_port: Annotated[
        str,
        typer.Option(
            help="ur:ADDRESS, franka:ADDRESS, ros2:DOMAIN[,KEY=VALUE]…, or MODULE:CLASS (docs/robot_port.md)."
        ),
    ],
    units: Annotated[list[str] | None, typer.Option(help="HOST:PORT of a section unit; once for each.")] = None,
    key: Annotated[Path | None, typer.Option(help="The skin's keys (robotskin keys FILE).", dir_okay=False)] = None,
    skin: Annotated[
        Path | None,
        typer.Option(
            help="Instead of --units: the declaration of another maker's skin (docs/skins_of_others.md).",
            exists=True,
            dir_okay=False,
        ),
    ] = None,
    behaviour: Annotated[str, typer.Option(help="What it does, as of robotskin run.")] = "skin_compliance",
    interface: Annotated[str, typer.Option(help="position, velocity or torque.")] = "position",
    layout: Annotated[
        Path | None,
        typer.Option(help="The skin's layout file; by default the robot's finished one.", exists=True, dir_okay=False),
    ] = None,
    calibration: Annotated[
        Path | None,
        typer.Option(
            help="A calibration of the skin's force sensors (robotskin calibrate).", exists=True, dir_okay=False
        ),
    ] = None,
    gains: Annotated[
        Path | None,
        typer.Option(help="A gain file (TOML); by default the robot's own.", exists=True, dir_okay=False),
    ] = None,
    speed_share: Annotated[
        float, typer.Option(help="Share of the velocity limits that may be used until confirmed.", min=0.01, max=1.0)
    ] = 0.2,
    confirmed: Annotated[
        bool, typer.Option("--confirmed", help="Robot and skin were tried: full speed from the start, no touch.")
    ] = False,
    skip_touch: Annotated[
        bool,
        typer.Option("--skip-touch", help="Ask for no touch of marked cells: nothing checks where the cells are."),
    ] = False,
    headless: Annotated[bool, typer.Option("--headless", help="No page.")] = False,
    seconds: Annotated[float, typer.Option(help="For how long with --headless; 0: until Ctrl-C.", min=0)] = 0.0,
    bind: Annotated[
        str | None, typer.Option(help="HOST:PORT of this machine for the skin; by default found by itself.")
    ] = None,
    fault_file: Annotated[
        Path, typer.Option("--fault-file", help="Where a fault leaves the last second of states (CSV).", dir_okay=False)
    ] = Path("robotskin_fault.csv"),
    record: Annotated[
        Path | None,
        typer.Option(help="Keep all that is felt and done in this file (MCAP); robotskin replay.", dir_okay=False),
    ] = None,
    foxglove: Foxglove = None,
    ros2: Ros2 = None,
    ros2_interface: Ros2Interface = None,
    ros2_commands: Ros2Commands = False,
    fleet: Fleet = None,
    json_file: Annotated[Path | None, typer.Option("--json", help="Write the figures here.", dir_okay=False)] = None,
    port: Annotated[int, typer.Option(help="First port to try for the page, on 127.0.0.1.", min=1, max=65535)] = 8080,
) -> None:
    """Run a behaviour on a robot and a skin that are really there; robotskin run is the same on simulated ones.

    Before anything moves, skin and robot are compared with layout, keys and model, and a few marked cells must be
    touched. The robot is slow until confirmed.
    Ctrl-C or SIGTERM stops it smoothly. Exit status 0: no fault stopped it.
    """
    from robotskin import control
    from robotskin import layout as layouts
    from robotskin.apps.options import refuse_in_page, refuse_unless
    from robotskin.calibration import Calibration
    from robotskin.choices import member
    from robotskin.cli._in_fleet import require_fleet
    from robotskin.cli._terminal import terminal
    from robotskin.connecting import ConnectedRobot, TouchOrder
    from robotskin.model import CommandMode
    from robotskin.outputs import require_writable
    from robotskin.ports import made_port
    from robotskin.robots.gains import robot_with_gains

    require_writable("--json", json_file, (".json",))
    refuse_in_page(headless, context, "json_file", "seconds")
    refuse_unless(not headless, context, "ros2_commands", because="is for the page")
    control.behaviour(behaviour)
    member("interface", CommandMode, interface)
    require_fleet(fleet)
    open_skin = way_to_skin(units or [], key, skin, bind)
    console = terminal()
    with waiting(f"loading {robot}"):
        ready = robot_with_gains(robot, gains)
        model, chosen = ready.robot, ready.gains
        worn = layouts.finished(model.name) if layout is None else layouts.Layout.load(layout)
        if calibration is not None:
            worn = Calibration.load(calibration).applied(worn)
    connected_skin = open_skin(worn)
    try:
        with waiting("waiting for the skin"):
            alive = connected_skin.await_skin()
        console.print(f"skin: {alive} of {len(worn)} cells speak")
        moved = made_port(robot_port, model)
        try:
            session = ConnectedRobot(
                model,
                worn,
                moved,
                connected_skin,
                behaviour,
                interface=interface,
                gains=chosen,
                fault_file=fault_file,
                speed_share=1.0 if confirmed else speed_share,
            )
            for line in session.seen:
                console.print(f"robot: {line}")
            order = None if confirmed or skip_touch else TouchOrder(worn)
            if skip_touch:
                console.print(
                    "skin: no touch was asked for, so nothing checks that its cells are where the layout says"
                )
            with shared(session, model, record, foxglove, ros2, ros2_interface, ros2_commands, fleet) as sharing:
                if headless:
                    status = run_headless(session, seconds, json_file, order)
                else:
                    status = show(session, port, sharing, order)
        finally:
            moved.stop()
            if hasattr(moved, "close"):
                moved.close()
    finally:
        connected_skin.close()
    if session.fault:
        console.print(session.fault_told)
    if connected_skin.error:
        console.print(f"skin: {connected_skin.error}", highlight=False)
    raise typer.Exit(status)


def way_to_skin(
    units: list[str], key: Path | None, skin: Path | None, bind: str | None
) -> Callable[[Layout], ConnectedSkin]:
    """What opens a layout's skin: section units, or another maker's. Raises InputError where both are asked for."""
    from robotskin.connecting import SectionUnits, unit_addresses
    from robotskin.errors import InputError
    from robotskin.keys import SkinKeys

    if skin is not None:
        if units or key is not None or bind is not None:
            raise InputError(
                f"--skin {skin}: another maker's skin has no section units: leave out --units, --key, --bind"
            )
        from robotskin.foreign import ForeignSkin, load

        declared = load(skin)
        return lambda worn: ForeignSkin(worn, declared)
    if key is None:
        raise InputError("--key: give the skin's keys (robotskin keys FILE), or --skin for another maker's skin")
    addresses, keys = unit_addresses(units), SkinKeys.load(key)
    own = None if bind is None else unit_addresses([bind])[0]
    return lambda worn: SectionUnits(worn, addresses, keys, own)


def begin(session: ConnectedRobot) -> None:
    """Take the forces' zero and start; tell where the loop has to wait for other programs."""
    session.begin()
    if not session.paced.realtime:
        typer.echo("loop: it waits for other programs; allow otherwise with 'ulimit -r 20', or run it as root")


def run_headless(session: ConnectedRobot, seconds: float, json_file: Path | None, order: TouchOrder | None) -> int:
    """Run for a time or until interrupted, tell and write the figures; the exit status."""
    from robotskin.cli._terminal import terminal
    from robotskin.figures import write_figures

    console = terminal()
    moved = 0.0
    try:
        if order is not None:
            session.check_order(order, lambda told: typer.echo(f"skin: {told}"))
        begin(session)
        console.print(f"running {session.behaviour}, {session.speed.told}")
        home = list(session.joints.position)
        ends = seconds if seconds > 0 else float("inf")
        gone, closed = 0.0, ""
        while gone < ends and not session.fault:
            session.run(min(0.1, ends - gone))
            gone += 0.1
            before, closed = closed, session.closed_ports()
            if closed != before:
                console.print(f"skin: {closed or 'every closed port is open again'}")
            moved = max(moved, *(abs(a - b) for a, b in zip(session.joints.position, home, strict=True)))
    except KeyboardInterrupt:
        console.print("bringing the robot to rest")
    finally:
        latency = session.latency()
        stopped_s = session.end()
    figures = {
        **latency,
        "largest_displacement_rad": moved,
        "stop_s": stopped_s,
        "ticks": float(session.loop.report.ticks),
        "lost_ticks": float(session.loop.report.lost),
        "limit_violations": float(session.controller.report.violations),
        "fallback_ticks": float(session.controller.cycle.fusion_counts.fallback_ticks),
        "clock_ticks": float(session.controller.cycle.fusion_counts.clock_ticks),
        "widened_ticks": float(session.controller.cycle.fusion_counts.widened_ticks),
        "faults": float(bool(session.fault)),
    }
    for name, value in figures.items():
        console.print(f"{name}: {value:.6g}", highlight=False)
    if json_file is not None:
        write_figures(json_file, 0, figures)
    return 1 if session.fault else 0


SWITCH_S = 0.0005
"""For which the page's thread may hold the interpreter while the robot's waits between two slices of its loop."""


def show(session: ConnectedRobot, port: int, sharing: Sharing, order: TouchOrder | None) -> int:
    """Serve the page until it is interrupted; the exit status. The terminal takes c (confirm), s (stop), g (go)."""
    import sys
    import threading

    from robotskin.cli._terminal import terminal
    from robotskin.live.connected_session import ConnectedSession
    from robotskin.viewer.page import Page

    console = terminal()
    sys.setswitchinterval(SWITCH_S)
    if order is None:
        begin(session)
    else:
        session.settle()
    with (
        ConnectedSession(session, order, lambda told: typer.echo(f"skin: {told}")) as live,
        Page(live, port) as page,
        sharing.heed(live),
    ):
        live.watch_page(lambda: len(page.server.get_clients()))
        page.server.on_client_disconnect(lambda _: live.look_for_page())
        console.print(f"open [bold]{page.address}[/] (Ctrl-C ends)", markup=True)
        console.print(f"{session.speed.told}; here: c confirms full speed, s stops, g goes on, each with Enter")
        try:
            while sys.stdin.isatty():
                said = sys.stdin.readline().strip()
                if said in live.terminal:
                    live.terminal[said]()
            threading.Event().wait()
        except KeyboardInterrupt:
            console.print("bringing the robot to rest")
    return 1 if session.fault or live.failure is not None else 0
