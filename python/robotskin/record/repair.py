# SPDX-License-Identifier: Apache-2.0
"""Mends a recording that was cut at any byte, so that every MCAP reader opens it."""

from __future__ import annotations

import os
from dataclasses import dataclass
from pathlib import Path

from mcap.records import Attachment, Channel, Header, Message, Metadata, Schema
from mcap.writer import CompressionType, Writer

from robotskin.record.mcap_file import RecordingFileError, is_whole, records

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
            schemas: dict[int, int] = {}
            channels: dict[int, int] = {}
            started = False
            for record in records(path):
                if isinstance(record, Header) and not started:
                    writer.start(record.profile, library="robotskin")
                    started = True
                elif not started:
                    continue
                elif isinstance(record, Schema) and record.id not in schemas:
                    schemas[record.id] = writer.register_schema(record.name, record.encoding, record.data)
                elif isinstance(record, Channel) and record.id not in channels:
                    schema = schemas.get(record.schema_id, 0)
                    channels[record.id] = writer.register_channel(
                        record.topic, record.message_encoding, schema, record.metadata
                    )
                elif isinstance(record, Message) and record.channel_id in channels:
                    writer.add_message(
                        channels[record.channel_id], record.log_time, record.data, record.publish_time, record.sequence
                    )
                    messages += 1
                    newest_ns = max(newest_ns, record.log_time)
                elif isinstance(record, Attachment):
                    writer.add_attachment(
                        record.create_time, record.log_time, record.name, record.media_type, record.data
                    )
                elif isinstance(record, Metadata):
                    writer.add_metadata(record.name, record.metadata)
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
