# SPDX-License-Identifier: Apache-2.0
"""`robotskin fleet`: the skins of several robots, seen and stopped from one place."""

from __future__ import annotations

import contextlib
import threading
import time
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from robotskin.cli._in_fleet import require_extra
from robotskin.cli._lazy import VerbCommand
from robotskin.cli._sharing import Foxglove, tell

if TYPE_CHECKING:
    from robotskin.fleet.watch import FleetWatch

app = typer.Typer(
    add_completion=False,
    no_args_is_help=True,
    help="See the skins of several robots from one place, and stop them: robotskin fleet keys, router, monitor, …",
)
File = Annotated[Path, typer.Argument(help="Your file of `robotskin fleet keys`.", dir_okay=False)]
REFRESH_S = 0.25


@app.callback()
def command() -> None:
    """See the skins of several robots from one place, and stop them."""


@app.command("keys")
def keys(
    folder: Annotated[Path, typer.Argument(help="Where the files of all members lie; only you may read them.")],
    robot: Annotated[list[str] | None, typer.Option(help="A robot's name; once for each.")] = None,
    monitor: Annotated[list[str] | None, typer.Option(help="One that sees and may stop all; once for each.")] = None,
    follower: Annotated[list[str] | None, typer.Option(help="One that only sees; once for each.")] = None,
    router: Annotated[
        str | None, typer.Option(help="HOST:PORT where all reach the router; 127.0.0.1:7447 unless told.")
    ] = None,
    replace: Annotated[bool, typer.Option("--replace", help="Make members anew that have a file.")] = False,
) -> None:
    """Make a file for each member: a certificate of its own, and what it may do.

    Called again it adds members; the router then needs its new file. Give each member its own file alone.
    """
    require_extra()
    from robotskin.fleet.authority import make_keys

    written = make_keys(folder, robot or [], monitor or [], follower or [], router, replace)
    typer.echo(f"Wrote {', '.join(str(path) for path in written)} (mode 0600).")


@app.command("router")
def router(
    file: File,
    listen: Annotated[
        str | None, typer.Option(help="HOST:PORT of this machine, where it is another than the members go to.")
    ] = None,
) -> None:
    """Connect the members of a fleet until interrupted, and let each do what its certificate allows."""
    require_extra()
    from robotskin.fleet import Member, Role
    from robotskin.fleet.link import open_router

    member = Member.load(file, Role.router)
    link = open_router(member, listen)
    typer.echo(f"router of {len(member.members)} members on {listen or member.router} (Ctrl-C ends)")
    try:
        threading.Event().wait()
    except KeyboardInterrupt:
        typer.echo("closed")
    finally:
        link.close()


@app.command("monitor")
def monitor(
    file: File,
    seconds: Annotated[float, typer.Option(help="Watch so long and print one table; 0: until interrupted.", min=0)] = 0,
    page: Annotated[bool, typer.Option("--page", help="Show it in the browser, too, with buttons that stop.")] = False,
    port: Annotated[int, typer.Option(help="First port to try for the page, on 127.0.0.1.", min=1, max=65535)] = 8080,
) -> None:
    """Watch all robots of a fleet: what they do, how whole their skins are, what touches them.

    In the terminal, type `stop NAME` or `stop all` and Enter. Exit status 1: nothing was seen.
    """
    require_extra()
    from robotskin.cli._terminal import terminal
    from robotskin.fleet import Member, Role
    from robotskin.fleet.table import rows, stop_told, table
    from robotskin.fleet.watch import FleetWatch

    console = terminal()
    member = Member.load(file, Role.monitor, Role.follower)
    with FleetWatch(member) as watch, contextlib.ExitStack() as stack:
        if page:
            from robotskin.viewer.fleet_page import FleetPage

            stop = (lambda name: stop_told(watch, None if name is None else [name])) if watch.may_stop else None
            shown = FleetPage(lambda: rows(watch.robots(), time.monotonic(), watch.connected), stop, "fleet", port)
            stack.enter_context(shown)
            console.print(f"open [bold]{shown.address}[/] (Ctrl-C ends)", markup=True)
        if seconds > 0:
            time.sleep(seconds)
            console.print(table(watch.robots(), time.monotonic(), watch.connected))
        else:
            _watch(watch)
        if not watch.robots():
            console.print("no robot is in the fleet: robotskin run ROBOT --fleet FILE", highlight=False)
            raise typer.Exit(1)


@app.command("stop")
def stop(
    file: File,
    robots: Annotated[list[str] | None, typer.Argument(help="Names of robots; none: all that are there.")] = None,
    seconds: Annotated[float, typer.Option(help="How long to wait until they obey.", min=0.1)] = 3.0,
) -> None:
    """Stop robots of a fleet. They start again from beside the robot alone.

    Exit status 0: each has said that it obeyed.
    """
    require_extra()
    from robotskin.fleet import Member, Role
    from robotskin.fleet.watch import FleetWatch

    with FleetWatch(Member.load(file, Role.monitor)) as watch:
        time.sleep(REFRESH_S)
        watch.await_robots(robots or [], seconds)
        raise typer.Exit(_stop(watch, robots or None, seconds))


@app.command("follow", cls=VerbCommand)
def follow(
    file: File,
    robot: Annotated[str, typer.Argument(help="Its name in the fleet.")],
    port: Annotated[int, typer.Option(help="First port to try for the page, on 127.0.0.1.", min=1, max=65535)] = 8080,
    foxglove: Foxglove = None,
) -> None:
    """Show another robot's skin in the browser as it feels now, until interrupted.

    Layout and robot come from there. It can only be looked at.
    """
    require_extra()
    from robotskin.cli._waiting import waiting
    from robotskin.fleet import Member, Role
    from robotskin.fleet.followed import FollowedRobot
    from robotskin.live.followed_skin import FollowedSkin
    from robotskin.sharing.follower import Show
    from robotskin.viewer.followed_page import FollowedPage

    member = Member.load(file, Role.monitor, Role.follower)
    with waiting(f"asking {robot} what it is"):
        followed = FollowedRobot(member, robot)
    with followed:
        also: list[Show] = []
        if foxglove is not None:
            from robotskin.sharing.foxglove_server import FoxgloveServer

            server = FoxgloveServer(followed.robot, followed.layout, foxglove)
            tell(server.told)
            also.append(server)
        title = f"{robot}: {followed.robot.name}, {len(followed.layout)} cells"
        with FollowedPage(FollowedSkin(followed, also), title, port) as page:
            typer.echo(f"{title}: open {page.address} (Ctrl-C ends)")
            try:
                threading.Event().wait()
            except KeyboardInterrupt:
                typer.echo("closed")


def _stop(watch: FleetWatch, robots: list[str] | None, seconds: float = 3.0) -> int:
    from robotskin.fleet.table import stops_told

    took = watch.stop(robots, seconds)
    typer.echo("\n".join(stops_told(took)))
    return 0 if took and all(took_s is not None for took_s in took.values()) else 1


def _watch(watch: FleetWatch) -> None:
    """The table until interrupted, drawn anew some times a second; what is typed stops robots."""
    import sys

    from rich.live import Live

    from robotskin.errors import RobotskinError
    from robotskin.fleet.table import table

    def listen() -> None:
        for line in sys.stdin:
            word, _, name = line.strip().partition(" ")
            if word == "stop" and name:
                try:
                    _stop(watch, None if name == "all" else [name])
                except RobotskinError as error:
                    typer.echo(str(error))

    if sys.stdin.isatty():
        threading.Thread(target=listen, name="terminal", daemon=True).start()
    try:
        with Live(refresh_per_second=4) as live:
            while True:
                live.update(table(watch.robots(), time.monotonic(), watch.connected))
                time.sleep(REFRESH_S)
    except KeyboardInterrupt:
        typer.echo("closed")
