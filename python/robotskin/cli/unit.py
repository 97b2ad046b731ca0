# SPDX-License-Identifier: Apache-2.0
"""`robotskin unit`: a section unit on this Linux machine, between serial lines and UDP."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer


def command(
    lines: Annotated[
        list[str], typer.Argument(help="Serial lines, /dev/tty… or a pseudo-terminal; the first is port 1.")
    ],
    key: Annotated[Path, typer.Option(help="The skin's keys (robotskin keys FILE).", dir_okay=False)],
    listen: Annotated[str, typer.Option(help="HOST:PORT where the host reaches it.")] = "127.0.0.1:21100",
    group: Annotated[int, typer.Option(help="Of section units, as the layout has it.", min=0, max=65535)] = 1,
    unit: Annotated[int, typer.Option(help="Number within the group.", min=0, max=15)] = 0,
    peer: Annotated[
        list[str] | None, typer.Option(help="HOST:PORT of another unit of the group; once for each.")
    ] = None,
    seconds: Annotated[float, typer.Option(help="For how long; 0: until Ctrl-C.", min=0)] = 0.0,
    json_file: Annotated[Path | None, typer.Option("--json", help="Write the counts here.", dir_okay=False)] = None,
    sysfs: Annotated[Path, typer.Option(help="Where the system tells of its devices.", hidden=True)] = Path("/sys"),
) -> None:
    """Serve the cells on serial lines at 4 Mb/s as a section unit.

    An adapter that holds bytes back for more than 2 ms is refused; a line that is pulled is opened again when it is
    back. Every ten seconds a line tells what has come.
    """
    import secrets
    import time

    from robotskin.addresses import host_and_port
    from robotskin.errors import InputError
    from robotskin.figures import write_figures
    from robotskin.keys import SkinKeys
    from robotskin.outputs import require_writable
    from robotskin.serial_lines import UnitDaemon

    require_writable("--json", json_file, (".json",))
    if time.time() < EARLIEST_S:
        raise InputError("the calendar of this machine was never set: replays are told by it; set it, such as by NTP")
    keys = SkinKeys.load(key)
    host, port = host_and_port(listen)
    peers = [host_and_port(one) for one in peer or ()]
    daemon = UnitDaemon(
        lines,
        host,
        port,
        key=keys.for_socket(host),
        cell_key=keys.cell_key,
        session=secrets.randbits(31) | 1,
        group=group,
        unit=unit,
        peers=peers,
        sysfs=str(sysfs),
    )
    daemon.start()
    try:
        typer.echo("section unit {}.{} at {}:{}".format(group, unit, *daemon.address))
        time.sleep(0.05)
        if not daemon.report()["realtime"]:
            typer.echo("not before other programs: allow it with 'ulimit -r 10', or run it as root")
        began = told = time.monotonic()
        while seconds == 0 or time.monotonic() - began < seconds:
            time.sleep(0.1)
            if time.monotonic() - told > TELL_S:
                told = time.monotonic()
                typer.echo(told_report(daemon.report()))
    finally:
        daemon.stop()
        report = daemon.report()
        typer.echo(told_report(report))
        if json_file is not None:
            write_figures(json_file, 0, figures_of(report))


EARLIEST_S = 1_735_689_600
"""2025: a calendar before that was never set."""
TELL_S = 10.0


def figures_of(report: dict[str, object]) -> dict[str, float]:
    """The counts of a report by name; those of lines as sums."""
    lines = report["lines"]
    assert isinstance(lines, list)
    figures = {name: float(sum(line[name] for line in lines)) for name in (lines[0] if lines else ())}
    figures |= {name: float(value) for name, value in report.items() if isinstance(value, int | float)}
    return figures


def told_report(report: dict[str, object]) -> str:
    """The counts in one line; of a report that names cells, also what to look at where none is named."""
    told = figures_of(report)
    names = ("named", "frames_in", "damaged", "frames_out", "pulled", "stalls")
    parts = [f"{name.replace('_', ' ')} {told[name]:.0f}" for name in names if name in told]
    return ", ".join([*parts, f"worst stall {1e3 * told['worst_stall_s']:.1f} ms"]) + _doubt(told)


def _doubt(told: dict[str, float]) -> str:
    if told.get("named", 1.0) > 0:
        return ""
    if told.get("frames_in", 0.0) > 0:
        return "; cells speak, but take no names: are their keys those of --key?"
    return "; nothing comes: is a cell powered, and its port wired out to in and in to out?"
