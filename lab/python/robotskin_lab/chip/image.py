# SPDX-License-Identifier: Apache-2.0
"""The firmware cross-built for a Cortex-M0+ class part, from the sources that every other cell is built from."""

from __future__ import annotations

import os
import shutil
import struct
import subprocess
import sys
import tempfile
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from importlib.util import find_spec
from pathlib import Path

from robotskin_lab.chip.errors import ChipError

FLASH_BYTES, RAM_BYTES = 48 * 1024, 12 * 1024
FLASH_START, RAM_START = 0x00000000, 0x20000000

SOURCES = Path(__file__).parents[4] / "firmware"
OPTIMISATION = "-O2"
FLAGS = (
    "-std=c11", "-ffreestanding", "-fomit-frame-pointer", "-ffunction-sections", "-fdata-sections",
    "-fno-unwind-tables", "-fno-asynchronous-unwind-tables", "-Wall", "-Wextra", "-Werror", "-g1",
    "-DRS_FRAMES_AT_WORDS",
)  # fmt: skip
CLANG = ("-target", "thumb-freestanding-eabi", "-mcpu=cortex_m0plus", "-fno-sanitize=undefined")
GCC = ("-mcpu=cortex-m0plus", "-mthumb", "-mfloat-abi=soft", "-masm-syntax-unified", "-nostdlib", "-nostartfiles")
GCC_NAME = "arm-none-eabi-gcc"


@dataclass(frozen=True)
class ChipImage:
    """What is written to the chip's flash, and where its landmarks are."""

    flash: bytes
    """From address 0 on: vectors, code, constants."""
    symbols: dict[str, int]
    """Addresses by name."""
    functions: tuple[tuple[int, str], ...]
    """Where each function begins, in the order of the addresses, those among them that only their file knows."""
    static_bytes: int
    """RAM of variables; the rest is the stack's."""

    @property
    def flash_bytes(self) -> int:
        """All that the image takes of the flash, the kilobyte included in which the cell keeps its settings."""
        return len(self.flash) + FLASH_BYTES - self.symbols["rs_kept_start"]


def build(
    optimisation: str = OPTIMISATION,
    firmware: Path = SOURCES,
    *,
    board: str = "emulated_board.c",
    options: Sequence[str] = (),
    compiler: str = "clang",
    elf: Path | None = None,
) -> ChipImage:
    """Cross-build the firmware with the clang of the `ziglang` wheel, or with a `compiler` "gcc" for ARM, if installed.

    Args:
        board: the file of firmware/chip that carries it.
        options: more ones for the compiler.
        elf: where to write the linked program, too.

    Raises ChipError if sources or compiler are not here, or do not compile without a warning.
    """
    if not (firmware / "chip" / "main.c").is_file():
        raise ChipError(f"{firmware}: no firmware sources here; the chip is built from a source tree")
    # main.c includes the board's, the checksum's and the front door's.
    found = [*sorted((firmware / "cell").rglob("*.c")), *sorted((firmware / "chip").glob("*.c"))]
    sources = [str(path) for path in found if path.stem not in ("crc", "step") and not path.stem.endswith("_board")]
    includes = [f"-I{firmware / folder}" for folder in ("chip/include", "include", ".", "chip")]
    with tempfile.TemporaryDirectory() as scratch:
        linked = elf or Path(scratch) / "cell.elf"
        # QEMU's machine has no wait states, and its board keeps more bytes; GCC's code for the RAM is too large for it.
        hot_in_ram = board == "emulated_board.c" and compiler == "clang"
        options = [*options, "-DRS_HOT_IN_RAM"] if hot_in_ram else options
        command = [
            *compiler_command(compiler),
            *FLAGS,
            f'-DRS_BOARD="{board}"',
            *options,
            optimisation,
            *includes,
            *sources,
        ]
        command += ["-T", str(firmware / "chip" / "cortex_m0plus.ld"), "-Wl,--gc-sections", "-o", str(linked)]
        command += ["-lgcc"] if compiler == "gcc" else []
        environment = {**os.environ, **compiler_caches()}
        done = subprocess.run(command, capture_output=True, text=True, env=environment, check=False)
        if done.returncode != 0:
            raise ChipError(f"the firmware does not build for the chip:\n{done.stderr.strip()[:4000]}")
        return read_elf(linked.read_bytes())


def compilers() -> list[str]:
    """Those that are here, of the two that `build` takes."""
    here = {"clang": find_spec("ziglang") is not None, "gcc": shutil.which(GCC_NAME) is not None}
    return [name for name, is_here in here.items() if is_here]


def compiler_command(compiler: str) -> list[str]:
    """The beginning of a command. Raises ChipError where it is not here."""
    if compiler == "clang":
        if find_spec("ziglang") is None:
            raise ChipError("the compiler is missing: `make build` installs it")
        return [sys.executable, "-m", "ziglang", "cc", *CLANG]
    if compiler == "gcc":
        program = shutil.which(GCC_NAME)
        if program is None:
            raise ChipError(f"{GCC_NAME} is not installed (Debian: gcc-arm-none-eabi)")
        return [program, *GCC]
    raise ChipError(f"{compiler!r} is no compiler: one of clang, gcc")


def read_elf(elf: bytes) -> ChipImage:
    """The image in a 32-bit little-endian ELF file. Raises ChipError for another file or one that does not fit."""
    if elf[:6] != b"\x7fELF\x01\x01":
        raise ChipError("the linker wrote no 32-bit little-endian ELF file")
    program_at, section_at = struct.unpack_from("<II", elf, 28)
    program_size, programs, section_size, sections = struct.unpack_from("<HHHH", elf, 42)
    flash = bytearray()
    top = RAM_START
    for index in range(programs):
        kind, at, address, physical, in_file, in_memory = struct.unpack_from(
            "<6I", elf, program_at + index * program_size
        )
        if kind != 1 or in_memory == 0:
            continue
        if in_file:
            flash.extend(b"\xff" * max(0, physical + in_file - len(flash)))
            flash[physical : physical + in_file] = elf[at : at + in_file]
        if address >= RAM_START:
            top = max(top, address + in_memory)
    symbols = _symbols(elf, section_at, section_size, sections)
    if top > RAM_START + RAM_BYTES or len(flash) > symbols["rs_kept_start"]:
        raise ChipError(f"{len(flash)} bytes of flash and {top - RAM_START} of RAM do not fit the chip")
    functions = _functions(elf, section_at, section_size, sections)
    return ChipImage(bytes(flash), symbols, functions, symbols["rs_bss_end"] - RAM_START)


def _symbols(elf: bytes, section_at: int, section_size: int, sections: int) -> dict[str, int]:
    return {name: value for name, value, _ in _symbol_table(elf, section_at, section_size, sections)}


def _functions(elf: bytes, section_at: int, section_size: int, sections: int) -> tuple[tuple[int, str], ...]:
    table = _symbol_table(elf, section_at, section_size, sections)
    return tuple(sorted({value & ~1: name for name, value, kind in table if kind == _FUNCTION}.items()))


_FUNCTION = 2


def _symbol_table(elf: bytes, section_at: int, section_size: int, sections: int) -> Iterator[tuple[str, int, int]]:
    """Name, value, kind."""
    headers = [struct.unpack_from("<10I", elf, section_at + index * section_size) for index in range(sections)]
    for header in headers:
        if header[1] != 2:
            continue
        names = headers[header[6]][4]
        for at in range(header[4], header[4] + header[5], 16):
            name, value = struct.unpack_from("<II", elf, at)
            end = elf.index(b"\0", names + name)
            yield elf[names + name : end].decode(), value, elf[at + 12] & 0xF


def compiler_caches() -> dict[str, str]:
    """Variables of the environment: where the compiler keeps what it has built, beside the build or at the user's."""
    tree = SOURCES.parent / "build"
    cache = (tree if tree.is_dir() else Path.home() / ".cache" / "robotskin") / "zig"
    return {"ZIG_GLOBAL_CACHE_DIR": str(cache), "ZIG_LOCAL_CACHE_DIR": str(cache)}
