# SPDX-License-Identifier: Apache-2.0
"""`robotskin cell`: a cell built for this machine, on a serial line, with sensors of your own."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer


def command(
    line: Annotated[str, typer.Argument(help="A serial line, or with --make the name of a pseudo-terminal to make.")],
    key: Annotated[Path | None, typer.Option(help="The skin's keys (robotskin keys FILE).", dir_okay=False)] = None,
    kept: Annotated[
        Path | None,
        typer.Option(
            help="Instead of --key: where it keeps the keys that robotskin commission gives it.", dir_okay=False
        ),
    ] = None,
    sensors: Annotated[
        str, typer.Option(help="MODULE:CLASS, or a library (.so) with rs_board_sense; by default nothing touches it.")
    ] = "robotskin.cell_sensors:Still",
    uid: Annotated[int, typer.Option(help="Serial number, from 1; each cell of a skin has its own.", min=1)] = 1,
    cell_id: Annotated[
        int, typer.Option("--id", help="Of the layout's cell; 0: the section unit names it.", min=0)
    ] = 0,
    port: Annotated[int, typer.Option(help="The cell's port at the line.", min=1, max=4)] = 1,
    make: Annotated[bool, typer.Option("--make", help="Make a pseudo-terminal of that name.")] = False,
    seconds: Annotated[float, typer.Option(help="For how long; 0: until Ctrl-C.", min=0)] = 0.0,
) -> None:
    """Run the firmware of a cell on this machine, in real time.

    With --kept it waits at its line for keys as long as there is no such file. To clear its keys, delete the file.
    """
    import secrets
    import time

    from robotskin.cell_sensors import made_sensors, read_counts
    from robotskin.cli.unit import told_report
    from robotskin.errors import InputError
    from robotskin.keys import KeptCellKeys, SkinKeys
    from robotskin.serial_lines import CellRunner, HostCell, LibrarySensors, SetSensors

    if (key is None) == (kept is None):
        raise InputError("--key, --kept: give one: the skin's keys, or where the cell keeps those that it is given")
    secret = None if key is None else SkinKeys.load(key).cell_key
    own = None if kept is None else KeptCellKeys.load(kept, uid)
    waits = kept is not None and own is None
    ends = [(-1, 0, 0 if number == port else -1) for number in range(1, 5)]
    cell = HostCell(uid, ends, cell_id, secrets.randbits(31), keys=own.keys if own else None, factory=waits)
    library = sensors.endswith(".so")
    plug_in = None if library else made_sensors(sensors)
    held = LibrarySensors(sensors) if library else SetSensors(1)
    runner = CellRunner([cell], secret, held, [(line, make)])
    runner.start()
    try:
        typer.echo(f"cell {uid} at {line}" + (": waits for its keys (robotskin commission)" if waits else ""))
        began = time.monotonic()
        while seconds == 0 or time.monotonic() - began < seconds:
            if waits and kept is not None and (given := runner.given_keys(0)) is not None:
                KeptCellKeys(uid, given).save(kept)
                runner.note_kept(0)
                waits = False
                typer.echo(f"has its keys, in {kept}")
            if plug_in is not None and isinstance(held, SetSensors):
                counts, fault = read_counts(sensors, plug_in, time.monotonic() - began)
                held.set(counts, [0] if fault else [])
            time.sleep(READ_S)
    finally:
        runner.stop()
        report = runner.report()
        typer.echo(f"samples {report['samples']}, {told_report(report)}")


READ_S = 0.002
