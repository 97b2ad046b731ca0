# SPDX-License-Identifier: Apache-2.0
"""A recorder beside a running robot: its thread empties the tapes and writes one MCAP file.

The threads of driver and control only copy into bounded tapes. Every 50 ms what was written is flushed as a chunk
of its own, so that a process that is killed loses no more than that and what is still on the tapes.
"""

from __future__ import annotations

import contextlib
import json
import struct
import threading
import time
from collections.abc import Mapping
from pathlib import Path
from types import TracebackType
from typing import Any, Protocol

import numpy as np
from numpy.typing import NDArray

import robotskin
from robotskin.driver import Driver
from robotskin.errors import RobotskinError
from robotskin.layout import Layout
from robotskin.loop import SkinLoop
from robotskin.record.messages import TOPICS, Message
from robotskin.record.tape import Entry
from robotskin.record.tape import Recorder as Tapes
from robotskin.skin import SkinReader

FORMAT_VERSION = 1
DRAIN_S = 0.02
FLUSH_S = 0.05
KEYFRAME_S = 5.0
"""A replay that is sought goes on within this time."""

HEADER = struct.Struct("<IHHq")


class RecordError(RobotskinError):
    """A recording that cannot be written or read; the message names the file and what to do."""


class Recorded(Protocol):
    """What can be recorded: a running skin with its driver and reader."""

    driver: Driver
    reader: SkinReader
    layout: Layout

    @property
    def loop(self) -> SkinLoop | None:
        """Whose joints and commands are recorded; None: no robot."""


class Recorder:
    """Records a running session into one MCAP file until `close`.

    Args:
        path: of the file, which must not exist. session: what is recorded.
        about: further facts for the file's metadata, such as seed and interface; attachments: further files by name.

    Raises:
        RecordError: the file exists or cannot be written, or the library that writes it is not installed.
    """

    def __init__(
        self,
        path: str | Path,
        session: Recorded,
        *,
        about: Mapping[str, Any] | None = None,
        attachments: Mapping[str, str] | None = None,
        driver_mib: float = 64.0,
    ) -> None:
        self.path = Path(path)
        self.error: str = ""
        """Why writing has stopped, such as a full disk; empty while it goes on. The robot goes on either way."""
        self.keyframe_s = KEYFRAME_S
        self._session = session
        self._tapes = Tapes(session.layout.skin_model(), driver_mib)
        self._file = _McapFile(self.path)
        self._file.attach_all(_attachments(session) | dict(attachments or {}))
        self._file.metadata(_about(session) | {name: str(value) for name, value in (about or {}).items()})
        self._file.flush()
        self._ending, self._emptied = threading.Event(), threading.Event()
        self._notes: list[str] = []
        self._tapes.attach(session.driver, session.reader, session.loop)
        self._thread = threading.Thread(target=self._work, name="skin recorder", daemon=True)
        self._thread.start()

    # ---- The control thread ----

    def close(self) -> None:
        """Write what is left and end the file. Raises RecordError if the file is not whole."""
        if self._ending.is_set():
            return
        self._tapes.detach(self._session.driver, self._session.reader, self._session.loop)
        self._ending.set()
        self._thread.join()
        if self.error:
            raise RecordError(f"{self.path}: {self.error}; what was written before is readable")

    def __enter__(self) -> Recorder:
        return self

    def __exit__(self, *_: type[BaseException] | BaseException | TracebackType | None) -> None:
        self.close()

    # ---- Any thread ----

    def note(self, text: str) -> None:
        """Take down what the operator did."""
        self._notes.append(text)

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
        while True:
            last = self._ending.is_set()
            try:
                self._write()
                self._emptied.set()
                now = time.monotonic()
                if now - flushed >= FLUSH_S or last:
                    self._file.flush()
                    flushed = now
                if now - keyframed >= self.keyframe_s:
                    self._tapes.ask_for_keyframe()
                    keyframed = now
                if last:
                    self._file.close()
                    return
            except Exception as error:
                # Whatever the disk or the library says: the robot goes on, and the user is told.
                self.error = str(error)
                self._file.abandon()
                return
            self._ending.wait(DRAIN_S)

    def _write(self) -> None:
        while True:
            control = self._tapes.drain_control()
            if control:
                self._write_control(control)
            driver, samples = self._tapes.drain_driver()
            if driver:
                self._file.log("/skin/tape", {"entries": driver}, _first_time_ns(driver))
            if samples["key"]:
                self._file.log("/skin/samples", samples, int.from_bytes(samples["stamp_ns"][:8], "little", signed=True))
            while self._notes:
                self._file.log("/operator", {"text": self._notes.pop(0).encode()}, self._file.newest_ns)
            if not driver and not control:
                return

    def _write_control(self, block: bytes) -> None:
        joints: list[tuple[int, bytes]] = []
        commands: list[tuple[int, bytes]] = []
        for kind, time_ns, payload in entries(block):
            if kind == Entry.joints.value:
                joints.append((time_ns, payload))
            elif kind == Entry.command.value:
                commands.append((time_ns, payload))
            elif kind == Entry.force_zero.value:
                self._tapes.set_zero(payload)
        self._file.log("/control/tape", {"entries": block}, _first_time_ns(block))
        if joints:
            times = np.array([time_ns for time_ns, _ in joints])
            rows = np.frombuffer(b"".join(payload for _, payload in joints)).reshape(len(joints), 3, -1)
            values = {"stamp_ns": times, "position": rows[:, 0], "velocity": rows[:, 1], "effort": rows[:, 2]}
            self._file.log("/robot/joints", values, int(times[0]))
        if commands:
            times = np.array([time_ns for time_ns, _ in commands])
            sent = np.frombuffer(b"".join(payload for _, payload in commands), np.uint64).reshape(len(commands), -1)
            values = {"time_ns": times, "mode": sent[:, 0], "value": sent[:, 1:].copy().view(np.float64)}
            self._file.log("/robot/commands", values, int(times[0]))


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


def _attachments(session: Recorded) -> dict[str, str]:
    from robotskin.layout.json_file import to_text

    found = {"layout.json": to_text(session.layout)}
    robot = getattr(session, "robot", None)
    if robot is not None:
        found["robot.urdf"] = robot.urdf
    return found


def _about(session: Recorded) -> dict[str, str]:
    facts = {
        "format_version": str(FORMAT_VERSION),
        "robotskin": robotskin.__version__,
        "cells": str(len(session.layout)),
        "robot": session.layout.robot,
        "clock": "host, nanoseconds; of the simulated world where there is one",
        "started": time.strftime("%Y-%m-%dT%H:%M:%SZ", time.gmtime()),
    }
    for name in ("seed", "interface", "mode"):
        if hasattr(session, name):
            facts[name] = str(getattr(session, name))
    robot = getattr(session, "robot", None)
    if robot is not None:
        facts["joints"] = json.dumps(list(robot.joint_names))
    return facts
