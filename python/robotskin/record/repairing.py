# SPDX-License-Identifier: Apache-2.0
"""Mends a recording that was cut at any byte, so that every MCAP reader opens it."""

from __future__ import annotations

import os
import struct
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from mcap.records import Channel, Header, Message, Schema
from mcap.writer import CompressionType, Writer

from robotskin.record.entries import HEADER
from robotskin.record.mcap_file import Damaged, RecordingFileError, declared, is_whole, records, require_file
from robotskin.record.messages import BLOCK
from robotskin.record.record_copy import RecordCopy
from robotskin.record.tape import Entry

CHUNK_BYTES = 1 << 20
TAPES = ("/skin/tape", "/control/tape")
MOST_NS = (1 << 63) - 1
"""What an entry of a tape holds; a later time is a damaged one."""


@dataclass(frozen=True)
class Repaired:
    """What a repair found: messages kept, the newest time among them, and chunks left out that were damaged."""

    messages: int
    newest_ns: int
    was_whole: bool
    damaged_chunks: int = 0
    gaps_told: int = 0
    """Messages that were not in the file before: they tell a replay where a chunk is missing."""

    @property
    def written(self) -> int:
        """Messages that any reader finds in the mended file."""
        return self.messages + self.gaps_told


def repair(path: str | Path) -> Repaired:
    """Write all that can be read of a file anew, with its indices, in its place; the old file stays until then.

    A damaged chunk is left out, and a gap told in its place: a replay goes on at the next keyframe. Where nothing is
    left before it, the recording begins behind it. A file that is
    whole is left as it is. Raises RecordingFileError for a file that is not there, is no MCAP, or has no message; it
    stays as it is.
    """
    path = Path(path)
    require_file(path)
    partial = path.with_name(f".{path.name}.partial")
    messages = newest_ns = damaged = gaps = 0
    whole = False
    try:
        with partial.open("wb") as file:
            writer = Writer(file, chunk_size=CHUNK_BYTES, compression=CompressionType.ZSTD)
            copy = RecordCopy(writer)
            started = False
            topics: dict[int, str] = {}
            for record in records(path, skip_damaged=True):
                if isinstance(record, Damaged):
                    damaged += 1
                    if messages:
                        gaps += _tell_gap(writer, copy, topics, newest_ns)
                    continue
                if isinstance(record, Channel):
                    topics[record.id] = record.topic
                if isinstance(record, Header) and not started:
                    writer.start(record.profile, library="robotskin")
                    started = True
                    # The chunk that declares them may be the damaged one.
                    for one in declared(path):
                        copy.put(one)
                        if isinstance(one, Channel):
                            topics[one.id] = one.topic
                if not started or _is_known(record, copy):
                    continue
                copy.put(record)
                if isinstance(record, Message) and record.channel_id in copy.channels:
                    messages += 1
                    if record.log_time <= MOST_NS:
                        newest_ns = max(newest_ns, record.log_time)
            if not messages:
                raise RecordingFileError(
                    f"{path}: it holds nothing that was felt: it cannot be mended, and stays as it is"
                )
            writer.finish()
            file.flush()
            os.fsync(file.fileno())
        whole = is_whole(path) and not damaged
        if not whole:
            partial.replace(path)
    except OSError as error:
        raise RecordingFileError(f"{path}: cannot be mended: {error.strerror}") from error
    finally:
        partial.unlink(missing_ok=True)
    return Repaired(messages, newest_ns, whole, damaged, gaps)


def _tell_gap(writer: Writer, copy: RecordCopy, topics: Mapping[int, str], time_ns: int) -> int:
    """On both tapes, a message each: how many entries are missing is not known, so one is told. How many messages."""
    payload = struct.pack("<Q", 1)
    entry = HEADER.pack(len(payload), Entry.gap.value, 0, time_ns) + payload
    tapes = [channel for channel, topic in topics.items() if topic in TAPES and channel in copy.channels]
    for channel in tapes:
        writer.add_message(copy.channels[channel], time_ns, BLOCK.pack({"entries": entry}), time_ns)
    return len(tapes)


def _is_known(record: Any, copy: RecordCopy) -> bool:
    """The summary at a file's end repeats schemas and channels."""
    known = copy.schemas if isinstance(record, Schema) else copy.channels if isinstance(record, Channel) else {}
    return bool(known) and record.id in known
