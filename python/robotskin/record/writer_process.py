# SPDX-License-Identifier: Apache-2.0
"""The process that writes a recording, as the robot's process sees it: started, told, and heard."""

from __future__ import annotations

import contextlib
import importlib.util
import json
import os
import subprocess
import sys
import threading
import time
from collections.abc import Callable, Mapping
from pathlib import Path
from typing import Any

import numpy as np

from robotskin.layout import Layout
from robotskin.record.entries import RecordError
from robotskin.record.tape_memory import TapeMemory

READY_WITHIN_S = 60.0
CPU_CLOCK_OF_PROCESS = 2
"""As Linux numbers the clocks of processes: all of its processor time (CPUCLOCK_SCHED)."""


class WriterProcess:
    """Writes one file beside the robot's process, until `end`.

    Args:
        path: of the file. layout: of the skin whose tapes are written. tapes: those of driver and control.
        attachments: texts by the names of files. about: facts by name.
        drain_s, flush_s: how often the tapes are emptied, and how often what was written is made to survive a kill.
        failed: hears, on another thread, why no more is written.

    Raises:
        RecordError: the file exists or cannot be written, or the library that writes it is not installed.
    """

    def __init__(
        self, path: Path, layout: Layout, tapes: tuple[TapeMemory, TapeMemory], *, attachments: Mapping[str, str],
        about: Mapping[str, str], drain_s: float, flush_s: float, failed: Callable[[str], None],
    ) -> None:  # fmt: skip
        if importlib.util.find_spec("foxglove") is None:
            raise RecordError(f"{path}: recording needs foxglove-sdk: pip install foxglove-sdk")
        reserve(path)
        descriptors = [tape.descriptor for tape in tapes]
        # In a session of its own: an interrupt from the keyboard ends the robot's process, which then ends this one.
        self._process = subprocess.Popen(
            [sys.executable, "-P", "-m", "robotskin.record.writer"],
            stdin=subprocess.PIPE, stdout=subprocess.PIPE, stderr=subprocess.STDOUT, pass_fds=descriptors,
            start_new_session=True,
        )  # fmt: skip
        self.path, self._failed = path, failed
        self._sending, self._drained = threading.Lock(), threading.Condition()
        self._ready, self._over = threading.Event(), threading.Event()
        self._asked = self._answered = 0
        self._error, self._said = "", ""
        calibration = layout.calibration
        key = layout.keys.astype(np.uint32)
        begin = {
            "path": str(path.resolve()), "tapes": descriptors, "key": key.tolist(),
            "calibration": None if calibration is None else [one.tolist() for one in calibration.offset_and_matrix()],
            "attachments": dict(attachments), "about": dict(about), "drain_s": drain_s, "flush_s": flush_s,
        }  # fmt: skip
        self._hearing = threading.Thread(target=self._hear, name="recording heard", daemon=True)
        self._hearing.start()
        text = json.dumps(begin).encode()
        self._send(len(text).to_bytes(4, "little") + text)
        if not self._ready.wait(READY_WITHIN_S) or self._error:
            self._process.kill()
            self._hearing.join()
            path.unlink(missing_ok=True)
            raise RecordError(f"{path}: cannot be recorded to: {self._error or 'the writer does not answer'}")

    @property
    def identity(self) -> int:
        """Of the process."""
        return self._process.pid

    @property
    def cpu_s(self) -> float:
        """Processor time that it has taken."""
        if self._over.is_set():
            return 0.0
        return time.clock_gettime(~self._process.pid << 3 | CPU_CLOCK_OF_PROCESS)

    def note(self, text: str) -> None:
        """Take down what the operator did."""
        self._tell({"note": text})

    def attach_late(self, name: str, text: str) -> None:
        """Write another attachment when the file ends."""
        self._tell({"attach": {name: text}})

    def drain(self, patience_s: float) -> None:
        """Wait until what is on the tapes now is in the file."""
        with self._drained:
            self._asked += 1
            asked = self._asked
            self._tell({"drain": asked})
            self._drained.wait_for(lambda: self._answered >= asked or self._over.is_set(), patience_s)

    def end(self) -> str:
        """Wait until the file is whole; why it is not, or nothing."""
        self._tell({"end": True})
        self._hearing.join()
        with self._sending, contextlib.suppress(OSError):
            assert self._process.stdin is not None
            self._process.stdin.close()
        return self._error

    def _tell(self, order: dict[str, Any]) -> None:
        self._send(json.dumps(order).encode() + b"\n")

    def _send(self, data: bytes) -> None:
        with self._sending:
            try:
                assert self._process.stdin is not None
                self._process.stdin.write(data)
                self._process.stdin.flush()
            except (OSError, ValueError):
                return  # it is gone; what it heard last is told by the thread that hears it

    def _hear(self) -> None:
        assert self._process.stdout is not None
        with self._process.stdout:
            for line in self._process.stdout:
                self._take(line)
        status = self._process.wait()
        if status != 0 and not self._error:
            self._error = self._said or ended_by(status)
        self._over.set()
        with self._drained:
            self._drained.notify_all()
        began = self._ready.is_set()
        self._ready.set()
        if self._error and began:
            self._failed(self._error)

    def _take(self, line: bytes) -> None:
        try:
            told = json.loads(line)
        except ValueError:
            self._said = line.decode(errors="replace").strip()
            return
        if "ready" in told:
            self._ready.set()
        elif "error" in told:
            self._error = told["error"]
        elif "drained" in told:
            with self._drained:
                self._answered = told["drained"]
                self._drained.notify_all()


def reserve(path: Path) -> None:
    """Make the empty file. Raises RecordError where it exists, or cannot be made."""
    try:
        path.parent.mkdir(parents=True, exist_ok=True)
        os.close(os.open(path, os.O_CREAT | os.O_EXCL | os.O_WRONLY, 0o666))
    except OSError as error:
        reason = "it exists: choose another name" if path.exists() else error.strerror
        if path.parent.is_file():
            reason = f"{path.parent} is no folder"
        raise RecordError(f"{path}: cannot be recorded to: {reason}") from error


def ended_by(status: int) -> str:
    """What an exit status says of the process that writes."""
    how = f"signal {-status}" if status < 0 else f"status {status}"
    return f"the process that writes it has ended with {how}"
