# SPDX-License-Identifier: Apache-2.0
"""`robotskin chip build`: the file that is copied to a chip."""

from __future__ import annotations

import secrets
from pathlib import Path
from typing import Annotated

import typer

from robotskin.errors import UnknownNameError
from robotskin.keys import SkinKeys
from robotskin.outputs import require_writable
from robotskin_lab.chip.pico_image import build_pico, cell_keys

BOARDS = ("pico",)

app = typer.Typer(help=__doc__, no_args_is_help=True)


@app.callback()
def chip() -> None:
    """The firmware of a cell for a chip that anyone can buy."""


@app.command("build")
def build(
    board: Annotated[str, typer.Argument(help="pico: a Raspberry Pi Pico (RP2040).")],
    file: Annotated[
        Path | None, typer.Argument(help="The UF2 file to write; by default cell_UID.uf2 here.", dir_okay=False)
    ] = None,
    key: Annotated[
        Path | None,
        typer.Option(help="The skin's keys, in the file; without, robotskin commission writes them over the cable."),
    ] = None,
    uid: Annotated[int, typer.Option(help="Serial number, 1 to 4294967295; 0: drawn.", min=0, max=4294967295)] = 0,
) -> None:
    """Cross-build the firmware for one cell: each has a file of its own, with its serial number."""
    if board not in BOARDS:
        raise UnknownNameError("board", board, BOARDS)
    chosen = uid or 1 + secrets.randbelow((1 << 32) - 1)
    file = file or Path(f"cell_{chosen}.uf2")
    require_writable("FILE", file, (".uf2",))
    keys = None if key is None else cell_keys(SkinKeys.load(key).cell_key, chosen)
    image = build_pico()
    file.write_bytes(image.uf2(chosen, keys))
    if keys is not None:
        file.chmod(0o600)
    size = f"{len(image.flash)} bytes of flash, {image.ram_bytes} of RAM"
    typer.echo(f"Wrote {file}: cell {chosen}, {'with' if keys else 'without'} keys, {size}.")
    typer.echo("Hold BOOTSEL, plug the Pico in, and copy the file to the disk that appears.")
    if keys is None:
        typer.echo("Then give it its keys: robotskin commission LINE --key FILE. One that has some keeps them.")
