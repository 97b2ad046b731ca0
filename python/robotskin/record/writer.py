# SPDX-License-Identifier: Apache-2.0
"""The process that writes a recording: it empties the tapes in shared memory, beside the robot's process.

It is started by `writer_process` and told what to do on its standard input, by a line of JSON each; it answers on its
standard output. Where the robot's process ends in any way, it writes what is still on the tapes and ends the file.
"""

from __future__ import annotations

import contextlib
import gc
import json
import os
import select
import signal
import sys
import time
from pathlib import Path
from typing import Any

import numpy as np

from robotskin.record.message_file import MessageFile
from robotskin.record.tape import TapeReader
from robotskin.record.tape_file import TapeFile
from robotskin.record.tape_memory import TapeMemory
from robotskin.skin import SkinModel

FILE_READER = 0
"""Which reader of the tapes writes the file; the other one is read in the robot's process."""


class Writer:
    """Writes one file, as the lines of the robot's process say; `begin` is the first of them."""

    def __init__(self, begin: dict[str, Any]) -> None:
        self._drain_s, self._flush_s = begin["drain_s"], begin["flush_s"]
        memory = [TapeMemory.opened(descriptor) for descriptor in begin["tapes"]]
        tapes = TapeReader(memory[0].bytes, memory[1].bytes, FILE_READER, model_of(begin))
        self._file = MessageFile(Path(begin["path"]))
        self._file.attach_all(begin["attachments"])
        self._file.metadata(begin["about"])
        self._file.flush()
        self._tape_file = TapeFile(tapes, self._file, np.array(begin["key"], np.uint32))
        self._late_attachments: dict[str, str] = {}
        self._ending = False

    def write(self) -> None:
        """Write until the robot's process says the end, or is gone."""
        flushed = time.monotonic()
        rest = b""
        robot = os.getppid()
        while not self._ending:
            # Its end of the pipe may live on in another process that it started.
            self._ending = os.getppid() != robot
            until_flush_s = max(0.0, flushed + self._flush_s - time.monotonic())
            ready, _, _ = select.select([0], [], [], min(self._drain_s, until_flush_s))
            self._tape_file.drain()
            if ready:
                got = os.read(0, 1 << 16)
                self._ending = self._ending or not got
                *lines, rest = (rest + got).split(b"\n")
                for line in lines:
                    self._obey(json.loads(line))
            if time.monotonic() - flushed >= self._flush_s:
                self._file.flush()
                flushed = time.monotonic()
        self._tape_file.drain()
        self._file.attach_all(self._late_attachments)
        self._file.close()

    def end(self, *_: object) -> None:
        """End after what is still on the tapes."""
        self._ending = True

    def _obey(self, order: dict[str, Any]) -> None:
        if "note" in order:
            self._tape_file.note(order["note"])
        elif "attach" in order:
            self._late_attachments |= order["attach"]
        elif "drain" in order:
            self._tape_file.drain()
            self._file.flush()
            tell({"drained": order["drain"]})
        elif "end" in order:
            self._ending = True


def model_of(begin: dict[str, Any]) -> SkinModel:
    """All of a skin that samples need: keys, and the calibration of its forces."""
    cells = len(begin["key"])
    model = SkinModel(
        link_names=["skin"], key=np.array(begin["key"], np.uint32), link=np.zeros(cells, np.int32),
        link_from_cell=np.tile(np.eye(4), (cells, 1, 1)),
        neighbours=np.tile(np.array([-1, 0], np.int32), (cells, 4, 1)), patch=np.full(cells, -1, np.int32),
    )  # fmt: skip
    if begin["calibration"] is not None:
        offset, matrix = begin["calibration"]
        model.set_force_calibration(np.array(offset), np.array(matrix))
    return model


def tell(what: dict[str, Any]) -> None:
    """A line for the robot's process, which may be gone."""
    with contextlib.suppress(OSError):
        os.write(1, json.dumps(what).encode() + b"\n")


def main() -> int:
    """Write what the first line says; the exit status is 0 where the file is whole."""
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    gc.disable()  # blocks come and go, none of them in a circle
    with contextlib.suppress(OSError):
        # A control thread that starts this may have a place of its own in front of all others; and what wakes as often
        # as this must not take a core from it in the middle of a tick.
        os.sched_setscheduler(0, os.SCHED_BATCH, os.sched_param(0))
    try:
        writer = Writer(first_order())
        signal.signal(signal.SIGTERM, writer.end)
        tell({"ready": True})
        writer.write()
    except Exception as error:
        # Whatever the disk or the library says: the robot goes on, and its process tells the user.
        tell({"error": str(error)})
        return 1
    return 0


def first_order() -> dict[str, Any]:
    """What stands first on standard input, behind its length: what to write, and where to."""
    size = int.from_bytes(exactly(4), "little")
    return json.loads(exactly(size))


def exactly(size: int) -> bytes:
    """So many bytes of standard input, and not one more. Raises EOFError where it ends before."""
    found = bytearray()
    while len(found) < size:
        got = os.read(0, size - len(found))
        if not got:
            raise EOFError("the robot's process has ended")
        found += got
    return bytes(found)


if __name__ == "__main__":
    sys.exit(main())
