# SPDX-License-Identifier: Apache-2.0
"""The cell's firmware on its chip, and the torque computed in the skin: size, cycles, errors, delays, compliance."""

from __future__ import annotations

import time
from collections.abc import Callable
from pathlib import Path
from typing import Annotated, Any

import typer

from robotskin_lab.bench.firmware_chip import CLOCK_HZ, cycle_figures, identity_figures, leaf_figures, size_figures
from robotskin_lab.bench.firmware_compliance import compliance_figures
from robotskin_lab.bench.firmware_delay import CELLS, delay_figures
from robotskin_lab.bench.firmware_machine import machine_figures
from robotskin_lab.bench.firmware_torque import operation_figures, sine_figures, torque_figures
from robotskin_lab.bench.progress import tell

PARTS = "chip", "torque", "delay", "compliance", "machine"


def run(
    *,
    seed: int = 1,
    parts: Annotated[
        str, typer.Option(help=f"With commas between them; all by default: {', '.join(PARTS)}.", show_default=False)
    ] = ",".join(PARTS),
    quick: Annotated[bool, typer.Option(help="A tenth of everything, for a look.")] = False,
    picture: Annotated[Path | None, typer.Option(help="Draw the delays into this file.", dir_okay=False)] = None,
) -> dict[str, Any]:
    """Build the firmware for a Cortex-M0+ class part, run it in an emulator, and measure torques computed in the skin.

    Needs the extra `chip`; where the minutes go is told at the end. Where GCC for ARM and QEMU are installed, the same
    firmware is built and booted there, too.
    """
    wanted = parts.split(",")
    unknown = [part for part in wanted if part not in PARTS]
    if unknown:
        raise typer.BadParameter(f"{unknown[0]!r}: the parts are {', '.join(PARTS)}")
    clock = Stopwatch()
    figures: dict[str, Any] = {}
    if "chip" in wanted:
        figures |= chip_figures(seed, clock, quick=quick)
    if "torque" in wanted:
        figures |= operation_figures(seed) | sine_figures()
        figures |= clock.around("torque", lambda: torque_figures(seed, 1000 if quick else 10_000))
    if "delay" in wanted:
        own_us = 1e6 * leaf_figures(seed)["cell_torque_cycles"] / CLOCK_HZ
        sizes = CELLS[:5] if quick else CELLS
        figures |= clock.around("delay", lambda: delay_figures(seed, own_us, sizes, picture))
    if "compliance" in wanted:
        figures |= clock.around("compliance", lambda: compliance_figures(seed, 1 if quick else 5))
    if "machine" in wanted:
        figures |= clock.around("machine", lambda: machine_figures(seed, 5 if quick else 50, 20 if quick else 60))
    return figures | clock.figures


def chip_figures(seed: int, clock: Stopwatch, *, quick: bool) -> dict[str, Any]:
    """Size, cycles, and the comparison with the host-built cell; the deepest stack of both runs counts as RAM."""
    size = size_figures()
    cycles = clock.around("cycles", lambda: cycle_figures(seed, 5 if quick else 50))
    identity = clock.around("identity", lambda: identity_figures(seed, 500 if quick else 10_000))
    stack = max(cycles["stack_bytes"], identity["identity_stack_bytes"])
    return size | {"ram_bytes": size["static_ram_bytes"] + stack} | cycles | identity | {"stack_bytes": stack}


class Stopwatch:
    """Processor time of parts of the bench."""

    def __init__(self) -> None:
        self.figures: dict[str, float] = {}

    def around(self, part: str, run: Callable[[], dict[str, Any]]) -> dict[str, Any]:
        """Run a part, tell what it is, and note its time."""
        tell(f"bench firmware: {part}")
        began = time.process_time()
        figures = run()
        self.figures[f"cpu_s_{part}"] = time.process_time() - began
        return figures
