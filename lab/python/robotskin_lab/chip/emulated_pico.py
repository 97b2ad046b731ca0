# SPDX-License-Identifier: Apache-2.0
"""A Pico in the emulator rp2040js: bytes at its pins in microseconds of its own, sensors as tables of registers."""

from __future__ import annotations

import json
import shutil
import subprocess
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from robotskin_lab import firmware
from robotskin_lab.chip.errors import ChipError
from robotskin_lab.chip.image import SOURCES

FOLDER = SOURCES.parent / "lab" / "rp2040"
HZ = 128_000_000


def missing() -> str:
    """Why no Pico can be emulated here; empty where one can."""
    if shutil.which("node") is None:
        return "Node.js is not installed (18 or newer)"
    if not (FOLDER / "node_modules" / "rp2040js").is_dir():
        return "rp2040js is not installed: run 'make emulator'"
    return ""


@dataclass
class Spoken:
    """What came out of the pins: port 1 to 4, end and beginning in microseconds, 20 bytes."""

    frames: list[tuple[int, float, float, bytes]] = field(default_factory=list)


class EmulatedPico:
    """Boots from a UF2 file; `run` lets its time pass.

    Args:
        uf2: path of the file.
        random: of the ring oscillator's bits.
        record: where to write what the board was asked and answered, of an image that was built with RS_RECORD.
        kept: the flash of an earlier one (`save_flash`), as after a power cycle; the image in it runs.
        forget: the pin that asks for that is at ground.

    Raises ChipError where Node or rp2040js is missing, or the chip would not boot.
    """

    def __init__(
        self,
        uf2: Path,
        random: int = 1,
        record: Path | None = None,
        *,
        kept: Path | None = None,
        forget: bool = False,
    ) -> None:
        if why := missing():
            raise ChipError(why)
        boot = {
            "uf2": str(uf2),
            "random": random,
            "record": None if record is None else str(record),
            "flash_bytes": firmware.FLASH_BYTES,
            "kept": None if kept is None else str(kept),
            "forget": forget,
        }
        command = ["node", str(FOLDER / "serve.mjs"), json.dumps(boot)]
        self._process = subprocess.Popen(command, stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True)
        self._sends: list[tuple[int, str, float]] = []
        self.now_us = 0.0
        self.told: dict[str, Any] = {}
        """The emulator's last answer: busy_cycles, framing_errors, restarts, and what it complained about (said)."""

    def send(self, port: int, data: bytes, percent: float = 0.0) -> None:
        """Put bytes on the line into port 1 to 4, from now on; `percent` faster than 4 Mb/s."""
        self._sends.append((port - 1, data.hex(), percent))

    def sensors(self, parts: dict[int, dict[int, int]] | None = None, adc: list[int] | None = None) -> None:
        """Set registers of parts on the I2C bus by address, and the readings of the five analogue inputs."""
        self._ask({"parts": parts or {}, **({"adc": adc} if adc else {})})

    def save_flash(self, file: Path) -> None:
        """Write the whole flash to a file."""
        self._ask({"save": str(file)})

    def unplug(self, address: int) -> None:
        """Take a part from the bus."""
        self._ask({"unplug": [address]})

    def registers(self, address: int) -> dict[int, int]:
        """What was written to a part."""
        return dict(self._ask({"show": address})["parts"])

    def run(self, until_us: float) -> list[tuple[int, float, float, bytes]]:
        """Until then, or until a frame has come out: frames as (port, end us, begin us, bytes)."""
        sends, self._sends = self._sends, []
        self.told = self._ask({"until_us": until_us, "send": sends})
        self.now_us = self.told["now_us"]
        return [(port + 1, end, begin, bytes.fromhex(frame)) for port, end, frame, begin in self.told["frames"]]

    def _ask(self, what: dict[str, Any]) -> dict[str, Any]:
        assert self._process.stdin is not None
        assert self._process.stdout is not None
        self._process.stdin.write(json.dumps(what) + "\n")
        self._process.stdin.flush()
        line = self._process.stdout.readline()
        if not line:
            raise ChipError("the emulated Pico has ended; its complaint stands on the error output")
        return dict(json.loads(line))

    def close(self) -> None:
        """End it, and write the record."""
        if self._process.poll() is None and self._process.stdin is not None:
            self._process.stdin.write('{"end": 1}\n')
            self._process.stdin.close()
        self._process.wait(20)
        if self._process.stdout is not None:
            self._process.stdout.close()
