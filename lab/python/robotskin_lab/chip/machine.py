# SPDX-License-Identifier: Apache-2.0
"""The cell's firmware on a machine of QEMU: the program as it would be written to a part, its four lines as sockets."""

from __future__ import annotations

import shutil
import socket
import struct
import subprocess
import tempfile
from pathlib import Path
from types import TracebackType

from robotskin_lab import firmware
from robotskin_lab.chip.errors import ChipError
from robotskin_lab.chip.image import ChipImage, build

BOARD = "mps2_an385_board.c"
QEMU = "qemu-system-arm"
SLOWER = 200
"""The cell's clock on such a machine is so much slower than ours: no program here keeps microseconds."""
_FUSES = 0x20003000
_PATIENCE_S = 30.0


def installed() -> str | None:
    """What is missing here to run such a machine, in words; None: nothing."""
    return None if shutil.which(QEMU) else f"{QEMU} is not installed (Debian: qemu-system-arm)"


def build_for_machine(elf: Path, compiler: str) -> ChipImage:
    """Build the firmware for the machine with `compiler` "clang" or "gcc" and write the program to `elf`."""
    return build(board=BOARD, options=[f"-DRS_BOARD_SLOWER={SLOWER}"], compiler=compiler, elf=elf)


class Machine:
    """A running mps2-an385 with the firmware of mps2_an385_board.c; `lines` are its ports 1 to 4, bytes both ways.

    Args:
        elf: the program.
        uid: the cell's serial number.
        random: what it draws from at its boot.
        key: of the skin, RS_CELL_KEY_BYTES, or None.

    Raises ChipError if QEMU is not installed or does not start. To be used in a `with` statement, which ends it.
    """

    def __init__(self, elf: Path, uid: int, random: int, key: bytes | None = None) -> None:
        missing = installed()
        if missing is not None:
            raise ChipError(missing)
        self._folder = tempfile.TemporaryDirectory()
        folder = Path(self._folder.name)
        fuses = folder / "fuses"
        made = firmware.cell_keys(key or bytes(firmware.CELL_KEY_BYTES), uid)
        fuses.write_bytes(struct.pack("<III", uid, random, key is not None) + made)
        command = [QEMU, "-M", "mps2-an385", "-display", "none", "-monitor", "none", "-kernel", str(elf)]
        command += ["-device", f"loader,file={fuses},addr={_FUSES:#x},force-raw=on"]
        listening = []
        for port in range(firmware.PORTS):
            path = folder / f"port{port + 1}"
            door = socket.socket(socket.AF_UNIX, socket.SOCK_STREAM)
            door.bind(str(path))
            door.listen(1)
            door.settimeout(_PATIENCE_S)
            listening.append(door)
            command += ["-chardev", f"socket,id=port{port + 1},path={path}", "-serial", f"chardev:port{port + 1}"]
        self._said = (folder / "said").open("w+")
        self._process = subprocess.Popen(command, stdin=subprocess.DEVNULL, stdout=self._said, stderr=self._said)
        self.lines: list[socket.socket] = []
        try:
            for door in listening:
                self.lines.append(door.accept()[0])
        except TimeoutError as error:
            raise ChipError(f"{QEMU} does not open its lines: {self.said()}") from error
        finally:
            for door in listening:
                door.close()
            if len(self.lines) < firmware.PORTS:
                self.close()
        for line in self.lines:
            line.setblocking(False)

    def said(self) -> str:
        """What QEMU has written, as it does when something is wrong."""
        self._said.seek(0)
        return self._said.read().strip()

    def close(self) -> None:
        """End the machine."""
        for line in self.lines:
            line.close()
        self._process.kill()
        self._process.wait()
        self._said.close()
        self._folder.cleanup()

    def __enter__(self) -> Machine:
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        self.close()
