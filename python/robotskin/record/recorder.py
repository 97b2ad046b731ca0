# SPDX-License-Identifier: Apache-2.0
"""A recorder beside a running robot: two bounded tapes, and a process that writes them into one MCAP file.

The threads of driver and control only copy into the tapes, which lie in shared memory. The other process shares nothing
else with them, no lock either. Every 45 ms what it wrote is flushed as a chunk of its own, so that a machine that fails
loses no more than that and what is still on the tapes; where the robot's process alone ends, nothing is lost.
"""

from __future__ import annotations

import contextlib
import threading
import time
from collections.abc import Callable, Mapping, Sequence
from pathlib import Path
from types import TracebackType
from typing import Any, Protocol

from robotskin.model import JointCommand, JointState
from robotskin.record.entries import RecordError, entries
from robotskin.record.facts import Recorded, about_of, attachments_of
from robotskin.record.tape import Entry, TapeReader
from robotskin.record.tape import Recorder as Tapes
from robotskin.record.tape_memory import TapeMemory
from robotskin.record.writer_process import WriterProcess

DRAIN_S = 0.045
"""Each time wakes the process that writes, and may take the caches of a control thread that shares its core."""
FOLLOWED_DRAIN_S = 0.002
"""While others look on: what they see is no older than this."""
FLUSH_S = 0.045

CONTROL_MIB = 16.0
FILE_READER, FOLLOWING_READER = 0, 1
"""Of the tapes: the process that writes the file, and the thread that feeds what looks on."""


class Following(Protocol):
    """What looks on while a skin works. All but `close` is called in the recorder's thread, and must not wait."""

    def begin(self, ask_for_keyframe: Callable[[], None]) -> None:
        """Blocks will come, from the first keyframe on; more of them can be asked for."""

    def take(self, driver: bytes, control: bytes, samples: Mapping[str, bytes]) -> None:
        """The next blocks of the two tapes; what is read in `control` needs what `driver` of the same call holds.

        samples: what is in `driver`, decoded, by the fields of `SKIN_SAMPLES`.
        """

    def close(self) -> None:
        """No more will come."""


class Recorder:
    """Records a running session into one MCAP file until `close`.

    Args:
        path: of the file, which must not exist; None: no file, others look on. session: what is recorded.
        about: further facts for the file's metadata, such as seed and interface; attachments: further files by name.
        followers: what looks on; the recorder closes them.
        attached: False: nothing is recorded before `attach`, and any thread may make the recorder.
        tell: hears at once, on the recorder's thread, why no more is written, such as a full disk.

    Raises:
        RecordError: the file exists or cannot be written, or the library that writes it is not installed.
    """

    def __init__(
        self,
        path: str | Path | None,
        session: Recorded,
        *,
        about: Mapping[str, Any] | None = None,
        attachments: Mapping[str, str] | None = None,
        followers: Sequence[Following] = (),
        driver_mib: float = 64.0,
        attached: bool = True,
        tell: Callable[[str], None] = lambda text: None,
    ) -> None:
        self.path = None if path is None else Path(path)
        self.error: str = ""
        """Why nothing is taken down any more, such as a full disk; empty while it is. The robot goes on either way."""
        self._session, self._tell = session, tell
        memory = TapeMemory.made("driver's tape", driver_mib), TapeMemory.made("control tape", CONTROL_MIB)
        self._tapes = Tapes(*(one.bytes for one in memory))
        self.followers = tuple(followers)
        """What looks on."""
        self.writer: WriterProcess | None = None
        """The process that writes the file; None: no file."""
        try:
            if self.path is not None:
                self._tapes.begin_reading(FILE_READER)
                self.writer = WriterProcess(
                    self.path, session.layout, memory,
                    attachments=attachments_of(session) | dict(attachments or {}),
                    about=about_of(session) | {name: str(value) for name, value in (about or {}).items()},
                    drain_s=DRAIN_S, flush_s=FLUSH_S, failed=self._failed,
                )  # fmt: skip
        finally:
            for one in memory:
                one.close()
        self._followed: TapeReader | None = None
        if self.followers:
            self._tapes.begin_reading(FOLLOWING_READER)
            driver, control = (one.bytes for one in memory)
            self._followed = TapeReader(driver, control, FOLLOWING_READER, session.layout.skin_model())
        for follower in self.followers:
            follower.begin(self._tapes.ask_for_keyframe)
        self._ending, self._emptied = threading.Event(), threading.Event()
        self._is_attached = False
        if attached:
            self.attach()
        self._thread = threading.Thread(target=self._work, name="skin recorder", daemon=True)
        self._thread.start()

    # ---- The control thread ----

    def attach(self) -> None:
        """Record from now on."""
        _attached[_known_by(self._session)] = self
        self._tapes.attach(self._session.driver, self._session.reader, self._session.loop)
        self._is_attached = True

    def detach(self) -> None:
        """Record no more; `close`, from any thread then, ends the file."""
        if self._is_attached:
            self._is_attached = False
            self._tapes.detach(self._session.driver, self._session.reader, self._session.loop)
            _attached.pop(_known_by(self._session), None)

    def moved(self, now_ns: int, joints: JointState, sent: JointCommand | None) -> None:
        """Take down what the robot told, and what was sent to it, of a session without a loop."""
        if self._is_attached:
            self._tapes.moved(now_ns, joints, sent)

    def close(self) -> None:
        """Write what is left and end the file. Raises RecordError if the file is not whole."""
        if self._ending.is_set():
            return
        self.detach()
        self._ending.set()
        self._thread.join()
        if self.writer is not None:
            self.writer.end()
        for follower in self.followers:
            follower.close()
        self._followed = None
        self._tapes.close()
        if self.error:
            raise RecordError(self._told())

    def _told(self) -> str:
        return f"{self.path}: nothing is recorded any more: {self.error}; what was written before is readable"

    def __enter__(self) -> Recorder:
        return self

    def __exit__(self, *_: type[BaseException] | BaseException | TracebackType | None) -> None:
        self.close()

    # ---- Any thread ----

    def note(self, text: str) -> None:
        """Take down what the operator did."""
        if self.writer is not None:
            self.writer.note(text)

    def attach_late(self, name: str, text: str) -> None:
        """Write another attachment when the file ends; it takes the place of an earlier one of that name."""
        if self.writer is not None:
            self.writer.attach_late(name, text)

    @property
    def dropped(self) -> int:
        """Entries for which a tape had no room; a replay passes over the time until the next keyframe."""
        return self._tapes.dropped

    @property
    def cpu_s(self) -> float:
        """Processor time taken so far, of the recorder's thread and of the process that writes, while both work."""
        of_thread = time.clock_gettime(time.pthread_getcpuclockid(self._thread.ident or 0))
        return of_thread + (0.0 if self.writer is None else self.writer.cpu_s)

    def drain(self, patience_s: float = 10.0) -> None:
        """Wait until what is on the tapes now was taken from them, and stands in the file."""
        if self.writer is not None:
            self.writer.drain(patience_s)
        if self._followed is not None:
            self._emptied.clear()
            self._emptied.wait(patience_s)

    # ---- The recorder's threads ----

    def _failed(self, error: str) -> None:
        """No more is written: the robot goes on, and the user is told."""
        self.error = error
        self._tapes.end_reading(FILE_READER)
        self._tell(self._told())

    def _work(self) -> None:
        """Feed what looks on."""
        while True:
            last = self._ending.is_set()
            if self._followed is not None:
                self._feed(self._followed)
            if last:
                return
            self._ending.wait(None if self._followed is None else FOLLOWED_DRAIN_S)

    def _feed(self, tapes: TapeReader) -> None:
        try:
            while True:
                control = tapes.drain_control()
                for entry in entries(control):
                    if entry.kind == Entry.force_zero.value:
                        tapes.set_zero(entry.payload)
                driver, samples = tapes.drain_driver()
                if not driver and not control:
                    break
                for follower in self.followers:
                    follower.take(driver, control, samples)
        except Exception as error:
            # Whatever looks on may fail as it likes: the robot goes on, and so does the file.
            self.error = self.error or str(error)
            self._followed = None
            self._tapes.end_reading(FOLLOWING_READER)
        self._emptied.set()


_attached: dict[int, Recorder] = {}
"""Drivers, or loops without one, at which a recorder looks on: each has room for one."""


def _known_by(session: Recorded) -> int:
    return id(session.loop if session.driver is None else session.driver)


def is_recorded(session: Recorded) -> bool:
    """Whether a recorder looks on at a session."""
    return _known_by(session) in _attached


def note(session: Recorded, text: str) -> None:
    """Take down what the operator did, where a recorder of the session writes a file. Any thread."""
    recorder = _attached.get(_known_by(session))
    if recorder is not None and recorder.path is not None:
        recorder.note(text)


def recorded(session: Recorded, path: Path | None) -> contextlib.AbstractContextManager[Recorder | None]:
    """A recorder of the session while a `with` block lasts; nothing where no path is given."""
    return contextlib.nullcontext() if path is None else Recorder(path, session)
