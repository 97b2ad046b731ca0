# SPDX-License-Identifier: Apache-2.0
"""Records of one MCAP file, written into another."""

from __future__ import annotations

from typing import Any

from mcap.records import Attachment, Channel, Message, Metadata, Schema
from mcap.writer import Writer


class RecordCopy:
    """Writes records in their order; schemas and channels get the writer's own numbers. The writer has been started."""

    def __init__(self, writer: Writer) -> None:
        self._writer = writer
        self.schemas: dict[int, int] = {}
        """Those of the writer, by those of the file that is read."""
        self.channels: dict[int, int] = {}
        """The same of channels."""

    def put(self, record: Any) -> None:
        """Write one. Messages of no known channel, and records that a writer makes itself, are left out."""
        writer = self._writer
        if isinstance(record, Schema):
            self.schemas[record.id] = writer.register_schema(record.name, record.encoding, record.data)
        elif isinstance(record, Channel):
            schema = self.schemas.get(record.schema_id, 0)
            self.channels[record.id] = writer.register_channel(
                record.topic, record.message_encoding, schema, record.metadata
            )
        elif isinstance(record, Message) and record.channel_id in self.channels:
            channel = self.channels[record.channel_id]
            writer.add_message(channel, record.log_time, record.data, record.publish_time, record.sequence)
        elif isinstance(record, Attachment):
            writer.add_attachment(record.create_time, record.log_time, record.name, record.media_type, record.data)
        elif isinstance(record, Metadata):
            writer.add_metadata(record.name, record.metadata)
