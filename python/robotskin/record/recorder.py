# SPDX-License-Identifier: Apache-2.0
"""A recorder beside a running robot: its thread empties the tapes and writes one MCAP file.

The threads of driver and control only copy into bounded tapes. Every 50 ms what was written is flushed as a chunk
of its own, so that a process that is killed loses no more than that and what is still on the tapes.
"""

from __future__ import annotations

import contextlib
import struct
import threading
import time
from collections.abc import Callable, Mapping, Sequence
from pathlib import Path
from types import TracebackType
from typing import Any, Protocol

import numpy as np
from numpy.typing import NDArray

from robotskin.errors import RobotskinError
from robotskin.model import JointCommand, JointState
from robotskin.record.facts import Recorded, about_of, attachments_of
from robotskin.record.felt import FeltSamples
from robotskin.record.messages import TOPICS, Message
from robotskin.record.tape import Entry
from robotskin.record.tape import Recorder as Tapes

DRAIN_S = 0.02
FOLLOWED_DRAIN_S = 0.002
"""While others look on: what they see is no older than this."""
FLUSH_S = 0.05
KEYFRAME_S = 5.0
"""A replay that is sought goes on within this time."""

HEADER = struct.Struct("<IHHq")


class RecordError(RobotskinError):
    """A recording that cannot be written or read; the message names the file and what to do."""


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
        """Why writing has stopped, such as a full disk; empty while it goes on. The robot goes on either way."""
        self.keyframe_s = KEYFRAME_S
        self._session, self._tell = session, tell
        self._tapes = Tapes(session.layout.skin_model(), driver_mib)
        self.followers = tuple(followers)
        """What looks on."""
        self._file: _McapFile | None = None
        if self.path is not None:
            self._file = _McapFile(self.path)
            self._file.attach_all(attachments_of(session) | dict(attachments or {}))
            self._file.metadata(about_of(session) | {name: str(value) for name, value in (about or {}).items()})
            self._file.flush()
        for follower in self.followers:
            follower.begin(self._tapes.ask_for_keyframe)
        self._ending, self._emptied = threading.Event(), threading.Event()
        self._notes: list[str] = []
        self._late_attachments: dict[str, str] = {}
        self._felt: FeltSamples | None = None
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
        for follower in self.followers:
            follower.close()
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
        self._notes.append(text)

    def attach_late(self, name: str, text: str) -> None:
        """Write another attachment when the file ends; it takes the place of an earlier one of that name."""
        self._late_attachments[name] = text

    @property
    def dropped(self) -> int:
        """Entries for which a tape had no room; a replay passes over the time until the next keyframe."""
        return self._tapes.dropped

    @property
    def clock_id(self) -> int:
        """Of the recorder's thread, for `time.clock_gettime`: the processor time that it has taken."""
        return time.pthread_getcpuclockid(self._thread.ident or 0)

    def drain(self, patience_s: float = 10.0) -> None:
        """Wait until the tapes were found empty once."""
        self._emptied.clear()
        self._emptied.wait(patience_s)

    # ---- The recorder's thread ----

    def _work(self) -> None:
        flushed = keyframed = time.monotonic()
        pause_s = FOLLOWED_DRAIN_S if self.followers else DRAIN_S
        while True:
            last = self._ending.is_set()
            now = time.monotonic()
            try:
                self._drain()
                self._emptied.set()
                if self._file is not None and (now - flushed >= FLUSH_S or last):
                    self._file.flush()
                    flushed = now
                if self._file is not None and last:
                    self._file.attach_all(self._late_attachments)
                    self._file.close()
            except Exception as error:
                # Whatever the disk or the library says: the robot goes on, and the user is told.
                self.error = str(error)
                if self._file is not None:
                    self._file.abandon()
                    self._file = None
                    self._tell(self._told())
            if now - keyframed >= self.keyframe_s:
                self._tapes.ask_for_keyframe()
                keyframed = now
            if last or (self._file is None and not self.followers):
                return
            self._ending.wait(pause_s)

    def _drain(self) -> None:
        while True:
            control = self._tapes.drain_control()
            if control and self._file is not None:
                self._write_control(self._file, control)
            elif control:
                self._keep_zero(control)
            driver, samples = self._tapes.drain_driver()
            if control or driver:
                for follower in self.followers:
                    follower.take(driver, control, samples)
            if self._file is not None:
                self._write(self._file, driver, samples)
            if not driver and not control:
                return

    def _write(self, file: _McapFile, driver: bytes, samples: Mapping[str, bytes]) -> None:
        if driver:
            file.log("/skin/tape", {"entries": driver}, _first_time_ns(driver))
        if samples["key"]:
            file.log("/skin/samples", samples, int.from_bytes(samples["stamp_ns"][:8], "little", signed=True))
        while self._notes:
            file.log("/operator", {"text": self._notes.pop(0).encode()}, file.newest_ns)

    def _write_felt(self, file: _McapFile, payload: bytes, time_ns: int) -> None:
        """The samples that are new in a state of a skin without our driver, for those that read samples."""
        if self._felt is None:
            self._felt = FeltSamples(self._session.layout)
        samples = self._felt.new_in(payload)
        if len(samples["key"]):
            file.log("/skin/samples", samples, time_ns)

    def _keep_zero(self, block: bytes) -> None:
        """Samples are told to followers with the same zero as to a file."""
        for kind, _, payload in entries(block):
            if kind == Entry.force_zero.value:
                self._tapes.set_zero(payload)

    def _write_control(self, file: _McapFile, block: bytes) -> None:
        joints: list[tuple[int, bytes]] = []
        commands: list[tuple[int, bytes]] = []
        for kind, time_ns, payload in entries(block):
            if kind == Entry.joints.value:
                joints.append((time_ns, payload))
            elif kind == Entry.command.value:
                commands.append((time_ns, payload))
            elif kind == Entry.force_zero.value:
                self._tapes.set_zero(payload)
            elif kind == Entry.felt.value:
                self._write_felt(file, payload, time_ns)
        file.log("/control/tape", {"entries": block}, _first_time_ns(block))
        if joints:
            times = np.array([time_ns for time_ns, _ in joints])
            rows = np.frombuffer(b"".join(payload for _, payload in joints)).reshape(len(joints), 3, -1)
            values = {"stamp_ns": times, "position": rows[:, 0], "velocity": rows[:, 1], "effort": rows[:, 2]}
            file.log("/robot/joints", values, int(times[0]))
        if commands:
            times = np.array([time_ns for time_ns, _ in commands])
            sent = np.frombuffer(b"".join(payload for _, payload in commands), np.uint64).reshape(len(commands), -1)
            values = {"time_ns": times, "mode": sent[:, 0], "value": sent[:, 1:].copy().view(np.float64)}
            file.log("/robot/commands", values, int(times[0]))


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


class _McapFile:
    """One MCAP file and its channels."""

    def __init__(self, path: Path) -> None:
        try:
            import foxglove
            from foxglove.mcap import MCAPCompression, MCAPWriteOptions
        except ImportError as error:
            raise RecordError(f"{path}: recording needs foxglove-sdk: pip install foxglove-sdk") from error
        context = self._context = foxglove.Context()  # which owns the channels
        options = MCAPWriteOptions(profile="", chunk_size=None, compression=MCAPCompression.Lz4, compression_threads=0)
        try:
            path.parent.mkdir(parents=True, exist_ok=True)
            self._writer = foxglove.open_mcap(path, context=context, writer_options=options)
        except (OSError, RuntimeError, ValueError) as error:
            reason = "it exists: choose another name" if path.exists() else str(error)
            raise RecordError(f"{path}: cannot be recorded to: {reason}") from error
        self._channels = {
            topic: (message, foxglove.Channel(topic, schema=_schema(message), message_encoding="protobuf",
                                              context=context))
            for topic, message in TOPICS.items()
        }  # fmt: skip
        self.newest_ns = 0

    def log(self, topic: str, values: Mapping[str, NDArray | bytes], time_ns: int) -> None:
        message, channel = self._channels[topic]
        self.newest_ns = max(self.newest_ns, time_ns)
        channel.log(message.pack(values), log_time=max(time_ns, 0))

    def attach_all(self, attachments: Mapping[str, str]) -> None:
        for name, text in attachments.items():
            kind = "application/json" if name.endswith(".json") else "text/plain"
            self._writer.attach(log_time=0, create_time=0, name=name, media_type=kind, data=text.encode())

    def metadata(self, values: Mapping[str, str]) -> None:
        self._writer.write_metadata("robotskin", dict(values))

    def flush(self) -> None:
        self._writer.flush()

    def close(self) -> None:
        self._writer.close()

    def abandon(self) -> None:
        """Close after an error, which may come again."""
        try:
            self._writer.close()
        except Exception:
            return


def entries(block: bytes) -> list[tuple[int, int, bytes]]:
    """(kind, time in ns, payload) of each entry of a tape's block. Raises RecordError for bytes that are none."""
    out = []
    at = 0
    while at < len(block):
        if len(block) - at < HEADER.size:
            raise RecordError("recording: a block ends within an entry")
        size, kind, _, time_ns = HEADER.unpack_from(block, at)
        at += HEADER.size
        if size > len(block) - at:
            raise RecordError(f"recording: an entry of {size} bytes passes its block")
        out.append((kind, time_ns, block[at : at + size]))
        at += (size + 7) // 8 * 8
    return out


def _first_time_ns(block: bytes) -> int:
    return int(HEADER.unpack_from(block, 0)[3])


def _schema(message: Message) -> Any:
    import foxglove

    return foxglove.Schema(name=message.schema_name, encoding="protobuf", data=message.descriptor())
