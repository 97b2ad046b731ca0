"""The cell's firmware on a machine of QEMU and under another compiler, where these are installed."""

from __future__ import annotations

import shutil
import tempfile
from pathlib import Path
from typing import Any

from robotskin.bench.progress import tell
from robotskin.chip import build
from robotskin.chip.image import GCC_NAME
from robotskin.chip.machine import Machine, build_for_machine, installed
from robotskin.chip.machine_skin import UID, MachineSkin, key_of

NAMED_LONGEST_MS = 100.0


def machine_figures(seed: int, milliseconds: float) -> dict[str, Any]:
    """Figures of each compiler, by its name: size, and what a machine does in a skin for so long; {} without QEMU."""
    figures: dict[str, Any] = {}
    with tempfile.TemporaryDirectory() as folder:
        for compiler in compilers():
            if compiler != "clang":
                image = build(compiler=compiler)
                figures[f"flash_bytes_{compiler}"] = image.flash_bytes
                figures[f"static_ram_bytes_{compiler}"] = image.static_bytes
            if installed() is None:
                tell(f"the machine of QEMU, {compiler}")
                elf = Path(folder) / compiler
                image = build_for_machine(elf, compiler)
                run = run_machine(elf, seed, milliseconds)
                run["flash_bytes"] = image.flash_bytes
                figures |= {f"machine_{name}_{compiler}": value for name, value in run.items()}
    return figures


def compilers() -> list[str]:
    """Those that are here."""
    return ["clang", "gcc"] if shutil.which(GCC_NAME) else ["clang"]


def run_machine(elf: Path, seed: int, milliseconds: float) -> dict[str, Any]:
    """Boot the program in a skin of four cells with a key, and look at what it does in so long a time of its own."""
    key = key_of(seed)
    with Machine(elf, UID, random=seed, key=key) as machine:
        skin = MachineSkin(machine, key)
        began_us = skin.now_us
        skin.run_until(skin.all_named, NAMED_LONGEST_MS)
        named_us = skin.now_us
        skin.run_until(lambda: False, milliseconds)
        skin.driver.command("ping")
        skin.run_until(lambda: len(skin.replies) >= len(skin.unit.names), NAMED_LONGEST_MS)
        own = skin.machine_id()
        return {
            "named_ms": (named_us - began_us) / 1000,
            "cells_named": len(skin.unit.names),
            "samples": sum(sample["source"] == own for sample in skin.heard.samples),
            "samples_wrong": len(skin.wrong_samples()),
            "samples_passed_on": sum(sample["source"] != own for sample in skin.heard.samples),
            "frames": sum(skin.heard.frames.values()),
            "replies": len(skin.replies),
        }
