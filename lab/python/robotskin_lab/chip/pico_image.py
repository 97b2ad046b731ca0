# SPDX-License-Identifier: Apache-2.0
"""The firmware for a Raspberry Pi Pico: cross-built, with what one cell is made with, as the UF2 file that it takes."""

from __future__ import annotations

import os
import struct
import subprocess
import tempfile
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

from robotskin_lab import firmware
from robotskin_lab.chip.errors import ChipError
from robotskin_lab.chip.image import FLAGS, SOURCES, compiler_caches, compiler_command

FLASH_AT, KEYS_AT, MADE_AT = 0x10000000, 0x101FE000, 0x101FF000
BOOT_BYTES = 256
PAGE = 256
FAMILY = 0xE48BFF56
"""Of the RP2040, among those that take UF2 files."""
INLINE = ("crc", "step")
"""Sources that main.c includes."""


@dataclass(frozen=True)
class PicoImage:
    """What is written to the flash of a Pico from its start, and RAM that code and variables take."""

    flash: bytes
    ram_bytes: int

    def uf2(self, uid: int, keys: bytes | None) -> bytes:
        """The file for one cell: serial number 1 to 2^32 - 1, and its `CELL_KEYS_BYTES` bytes of keys.

        None: it keeps the keys that it has, and waits for some over a line if it has none.
        """
        if not 0 < uid < 1 << 32:
            raise ChipError(f"serial number {uid}: must be 1 to 4294967295")
        pages = [(FLASH_AT + at, self.flash[at : at + PAGE]) for at in range(0, len(self.flash), PAGE)]
        pages.append((MADE_AT, struct.pack("<I", uid)))
        if keys is not None:
            pages.append((KEYS_AT, struct.pack("<I", 1) + keys))
        return b"".join(
            struct.pack("<8I", 0x0A324655, 0x9E5D5157, 0x2000, address, PAGE, number, len(pages), FAMILY)
            + page.ljust(PAGE, b"\xff").ljust(476, b"\0")
            + struct.pack("<I", 0x0AB16F30)
            for number, (address, page) in enumerate(pages)
        )


def build_pico(firmware_folder: Path = SOURCES, options: Sequence[str] = (), elf: Path | None = None) -> PicoImage:
    """Cross-build with the clang of the `ziglang` wheel. Raises ChipError where sources or compiler are missing."""
    chip = firmware_folder / "chip"
    if not (chip / "pico" / "rp2040_board.c").is_file():
        raise ChipError(f"{firmware_folder}: no firmware sources here; the chip is built from a source tree")
    found = [
        *sorted((firmware_folder / "cell").rglob("*.c")),
        *sorted(chip.glob("*.c")),
        *sorted(chip.glob("pico/*.c")),
    ]
    sources = [str(path) for path in found if path.stem not in INLINE and not path.stem.endswith("_board")]
    includes = [f"-I{firmware_folder / folder}" for folder in ("chip/include", "include", ".", "chip")]
    with tempfile.TemporaryDirectory() as scratch:
        linked = elf or Path(scratch) / "cell.elf"
        command = [*compiler_command("clang"), *FLAGS, '-DRS_BOARD="pico/rp2040_board.c"', *options, "-O2", *includes]
        command += [*sources, "-T", str(chip / "pico" / "rp2040.ld"), "-Wl,--gc-sections", "-o", str(linked)]
        environment = {**os.environ, **compiler_caches()}
        done = subprocess.run(command, capture_output=True, text=True, env=environment, check=False)
        if done.returncode != 0:
            raise ChipError(f"the firmware does not build for the Pico:\n{done.stderr.strip()[:4000]}")
        return read_pico(linked.read_bytes())


def read_pico(elf: bytes) -> PicoImage:
    """The image in a 32-bit little-endian ELF file, with the checksum of its first 252 bytes."""
    if elf[:6] != b"\x7fELF\x01\x01":
        raise ChipError("the linker wrote no 32-bit little-endian ELF file")
    (program_at,) = struct.unpack_from("<I", elf, 28)
    size, programs = struct.unpack_from("<HH", elf, 42)
    flash, ram = bytearray(), 0
    for index in range(programs):
        kind, at, address, physical, in_file, in_memory = struct.unpack_from("<6I", elf, program_at + index * size)
        if kind != 1 or in_memory == 0:
            continue
        ram += in_memory if address >= 0x20000000 else 0
        if in_file:
            offset = physical - FLASH_AT
            flash.extend(b"\xff" * max(0, offset + in_file - len(flash)))
            flash[offset : offset + in_file] = elf[at : at + in_file]
    flash[BOOT_BYTES - 4 : BOOT_BYTES] = struct.pack("<I", boot_checksum(bytes(flash[: BOOT_BYTES - 4])))
    return PicoImage(bytes(flash), ram)


def boot_checksum(data: bytes) -> int:
    """CRC-32 as the chip's ROM takes it: 0x04C11DB7 from all ones, bits as they come, not inverted."""
    checksum = 0xFFFFFFFF
    for byte in data:
        checksum ^= byte << 24
        for _ in range(8):
            checksum = (checksum << 1 ^ 0x04C11DB7) & 0xFFFFFFFF if checksum & 0x80000000 else checksum << 1
    return checksum


def cell_keys(secret: bytes, uid: int) -> bytes:
    """The keys that a cell is made with, from the secret of the skin's section units."""
    return bytes(firmware.cell_keys(secret, uid))
