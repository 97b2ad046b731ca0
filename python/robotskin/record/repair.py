# SPDX-License-Identifier: Apache-2.0
"""Mends a recording that was cut at any byte, so that every MCAP reader opens it."""

from __future__ import annotations

import os
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from mcap.records import Channel, Header, Message, Schema
from mcap.writer import CompressionType, Writer

from robotskin.record.mcap_file import RecordingFileError, is_whole, records
from robotskin.record.record_copy import RecordCopy

CHUNK_BYTES = 1 << 20


@dataclass(frozen=True)
class Repaired:
    """What a repair found: messages kept, and the newest time among them."""

    messages: int
    newest_ns: int
    was_whole: bool


def repair(path: str | Path) -> Repaired:
    """Write all that can be read of a file anew, with its indices, in its place; the old file stays until then.

    A file that is whole is left as it is. Raises RecordingFileError for a file that is no MCAP, or has no message.
    """
    path = Path(path)
    partial = path.with_name(f".{path.name}.partial")
    messages = newest_ns = 0
    whole = False
    try:
        with partial.open("wb") as file:
            writer = Writer(file, chunk_size=CHUNK_BYTES, compression=CompressionType.ZSTD)
            copy = RecordCopy(writer)
            started = False
            for record in records(path):
                if isinstance(record, Header) and not started:
                    writer.start(record.profile, library="robotskin")
                    started = True
                if not started or _is_known(record, copy):
                    continue
                copy.put(record)
                if isinstance(record, Message) and record.channel_id in copy.channels:
                    messages += 1
                    newest_ns = max(newest_ns, record.log_time)
            if not started:
                raise RecordingFileError(f"{path}: nothing but its first bytes is there: it cannot be mended")
            writer.finish()
            file.flush()
            os.fsync(file.fileno())
        whole = is_whole(path)
        if not whole:
            partial.replace(path)
    except OSError as error:
        raise RecordingFileError(f"{path}: cannot be mended: {error.strerror}") from error
    finally:
        partial.unlink(missing_ok=True)
    return Repaired(messages, newest_ns, whole)


def _is_known(record: Any, copy: RecordCopy) -> bool:
    """The summary at a file's end repeats schemas and channels."""
    known = copy.schemas if isinstance(record, Schema) else copy.channels if isinstance(record, Channel) else {}
    return bool(known) and record.id in known
