# SPDX-License-Identifier: Apache-2.0
"""`python -m robotskin_lab.chip`: the firmware built by one compiler and booted on a machine of QEMU, in a skin."""

import tempfile
from pathlib import Path
from typing import Annotated

import typer

from robotskin_lab.chip.machine import build_for_machine
from robotskin_lab.chip.machine_skin import run_machine


def main(
    compiler: Annotated[str, typer.Option(help="clang (of the extra chip) or gcc (for ARM, if installed).")] = "clang",
    milliseconds: Annotated[float, typer.Option(help="How long it runs by its own clock, which is slow.")] = 60,
    seed: Annotated[int, typer.Option(help="Of the skin's key and what the cell draws.")] = 1,
) -> None:
    """Build the firmware for QEMU's mps2-an385, boot it among a section unit and three cells, and tell what it did."""
    with tempfile.TemporaryDirectory() as folder:
        elf = Path(folder) / "cell.elf"
        image = build_for_machine(elf, compiler)
        print(f"{image.flash_bytes} bytes of flash, {image.static_bytes} of variables, by {compiler}")
        ran = run_machine(elf, seed, milliseconds)
    print(
        f"{ran['cells_named']:.0f} cells named after {ran['named_ms']:.1f} ms; "
        f"{ran['cells_answering']:.0f} answer a ping"
    )
    print(
        f"{ran['samples']:.0f} samples of the machine, {ran['samples_wrong']:.0f} of them wrong; "
        f"{ran['samples_passed_on']:.0f} of others passed on; {ran['frames']:.0f} frames in all"
    )


if __name__ == "__main__":
    typer.run(main)
