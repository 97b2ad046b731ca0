# SPDX-License-Identifier: Apache-2.0
"""`robotskin fleet`: the skins of several robots, seen and stopped from one place."""

from __future__ import annotations

import threading
import time
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

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
    _require_extra()
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
    _require_extra()
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
) -> None:
    """Watch all robots of a fleet: what they do, how whole their skins are, what touches them.

    In the terminal, type `stop NAME` or `stop all` and Enter. Exit status 1: nothing was seen.
    """
    _require_extra()
    from rich.console import Console

    from robotskin.fleet import Member, Role
    from robotskin.fleet.table import table
    from robotskin.fleet.watch import FleetWatch

    console = Console()
    with FleetWatch(Member.load(file, Role.monitor, Role.follower)) as watch:
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
    _require_extra()
    from robotskin.fleet import Member, Role
    from robotskin.fleet.watch import FleetWatch

    with FleetWatch(Member.load(file, Role.monitor)) as watch:
        time.sleep(REFRESH_S)
        watch.await_robots(robots or [], seconds)
        raise typer.Exit(_stop(watch, robots or None, seconds))


def _stop(watch: FleetWatch, robots: list[str] | None, seconds: float = 3.0) -> int:
    took = watch.stop(robots, seconds)
    for name, took_s in took.items():
        typer.echo(f"{name}: " + (f"obeyed after {took_s * 1e3:.0f} ms" if took_s is not None else "DID NOT ANSWER"))
    if not took:
        typer.echo("no robot is in the fleet")
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


def _require_extra() -> None:
    from robotskin.fleet import FleetError

    try:
        import cryptography  # noqa: F401
        import zenoh  # noqa: F401
    except ImportError as error:
        raise FleetError(f"fleet: {error.name} is not installed: pip install 'robotskin[fleet]'") from error
