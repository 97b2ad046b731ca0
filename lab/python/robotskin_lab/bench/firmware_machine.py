# SPDX-License-Identifier: Apache-2.0
"""The cell's firmware on a machine of QEMU and under another compiler, where these are installed."""

from __future__ import annotations

import tempfile
from pathlib import Path
from typing import Any

from robotskin_lab.bench.firmware_chip import BUDGET_CYCLES, busiest_cell, metered
from robotskin_lab.bench.progress import tell
from robotskin_lab.chip import build
from robotskin_lab.chip.image import compilers
from robotskin_lab.chip.machine import build_for_machine, installed
from robotskin_lab.chip.machine_skin import run_machine


def machine_figures(seed: int, samples: int, milliseconds: float) -> dict[str, Any]:
    """Figures of each compiler, by its name: size, cycles in so many sample periods, and what a machine does in a skin
    for so long; those alone for which there is what they need."""
    figures: dict[str, Any] = {}
    with tempfile.TemporaryDirectory() as folder:
        for compiler in compilers():
            if compiler != "clang":
                image = build(compiler=compiler)
                figures[f"flash_bytes_{compiler}"] = image.flash_bytes
                figures[f"static_ram_bytes_{compiler}"] = image.static_bytes
                _, worst = metered(*busiest_cell(seed, image), samples)
                figures[f"cycle_budget_percent_48mhz_250hz_{compiler}"] = 100 * worst.cycles / BUDGET_CYCLES
            if installed() is None:
                tell(f"the machine of QEMU, {compiler}")
                elf = Path(folder) / compiler
                image = build_for_machine(elf, compiler)
                run = run_machine(elf, seed, milliseconds)
                run["flash_bytes"] = image.flash_bytes
                figures |= {f"machine_{name}_{compiler}": value for name, value in run.items()}
    return figures
