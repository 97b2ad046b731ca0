# SPDX-License-Identifier: Apache-2.0
"""The host-built program against the record of an emulated Pico: given the same answers it must ask the same."""

from __future__ import annotations

import json
import os
import shutil
import subprocess
from pathlib import Path

from robotskin_lab.chip.emulated_pico import FOLDER
from robotskin_lab.chip.errors import ChipError
from robotskin_lab.chip.image import SOURCES

RECORDING = "-DRS_RECORD=0x4006C100"
"""Option of the build: each question and answer goes to an address that the emulator owns."""


def replay(record: Path, scratch: Path, uid: int, keys: bytes | None) -> dict[str, int]:
    """Calls by kind and `differences`, of a record made with that serial number and those keys.

    Raises ChipError: no C compiler (cc), or the program does not build.
    """
    compiler = shutil.which("cc")
    if compiler is None:
        raise ChipError("no C compiler (cc) for the host-built program")
    program = scratch / "replay"
    cells = [str(path) for path in sorted((SOURCES / "cell").rglob("*.c")) if path.stem not in ("crc", "step")]
    includes = [f"-I{SOURCES / folder}" for folder in ("include", ".", "chip")]
    board = f'-DRS_BOARD="{FOLDER / "replay_board.c"}"'
    command = [compiler, "-std=c11", "-O1", "-DRS_FRAMES_AT_WORDS", board, *includes, *cells]
    command += [str(SOURCES / "chip" / "main.c"), "-o", str(program)]
    built = subprocess.run(command, capture_output=True, text=True, check=False)
    if built.returncode != 0:
        raise ChipError(f"the program does not build for this machine:\n{built.stderr[:2000]}")
    told = {"LOG": str(record), "UID_OF_CELL": str(uid), "KEYS": (keys or b"").hex()}
    ran = subprocess.run([str(program)], capture_output=True, text=True, env={**os.environ, **told}, check=False)
    if not ran.stdout:
        raise ChipError(f"the replay ended with {ran.returncode}: {ran.stderr[:500]}")
    return {name: int(value) for name, value in json.loads(ran.stdout).items()}
