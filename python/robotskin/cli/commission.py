# SPDX-License-Identifier: Apache-2.0
"""`robotskin commission`: write a cell's keys over the cable."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer


def command(
    line: Annotated[str, typer.Argument(help="The serial line to which the cell is alone connected.")],
    key: Annotated[Path, typer.Option(help="The skin's keys (robotskin keys FILE).", dir_okay=False)],
    uid: Annotated[int, typer.Option(help="Serial number of the cell; 0: whichever it is.", min=0)] = 0,
    seconds: Annotated[float, typer.Option(help="For how long it is tried.", min=0.1)] = 3.0,
) -> None:
    """Give a cell that has no keys those of a skin, once; it takes no others afterwards.

    What goes over the cable is the group's key and the cell's own, never the skin's secret. Keys that are lost are
    cleared at the cell's board, by hand; then it takes new ones.
    """
    from robotskin.keys import SkinKeys
    from robotskin.serial_lines import commission

    keys = SkinKeys.load(key)
    found = commission(line, keys.cell_key, uid or None, seconds)
    typer.echo(f"cell {found} has its keys of {key}")
