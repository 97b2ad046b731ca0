# SPDX-License-Identifier: Apache-2.0
"""One MCAP file that is written: a channel for each message of a recording."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import Any

import foxglove
from foxglove.mcap import MCAPCompression, MCAPWriteOptions
from numpy.typing import NDArray

from robotskin.record.messages import TOPICS, Message


class MessageFile:
    """Writes messages until `close`; what was flushed survives a kill.

    path: of the file, which is written over. Raises OSError, RuntimeError or ValueError where it cannot be written.
    """

    def __init__(self, path: Path) -> None:
        context = self._context = foxglove.Context()  # which owns the channels
        options = MCAPWriteOptions(profile="", chunk_size=None, compression=MCAPCompression.Lz4, compression_threads=0)
        self._writer = foxglove.open_mcap(path, allow_overwrite=True, context=context, writer_options=options)
        self._channels = {
            topic: (message, foxglove.Channel(topic, schema=_schema(message), message_encoding="protobuf",
                                              context=context))
            for topic, message in TOPICS.items()
        }  # fmt: skip
        self.newest_ns = 0
        """Host clock of the newest message."""

    def log(self, topic: str, values: Mapping[str, NDArray | bytes], time_ns: int) -> None:
        """Write one message, by the fields of its topic (`TOPICS`), at a time of the host's clock."""
        message, channel = self._channels[topic]
        self.newest_ns = max(self.newest_ns, time_ns)
        channel.log(message.pack(values), log_time=max(time_ns, 0))

    def attach_all(self, attachments: Mapping[str, str]) -> None:
        """Write texts by the names of files."""
        for name, text in attachments.items():
            kind = "application/json" if name.endswith(".json") else "text/plain"
            self._writer.attach(log_time=0, create_time=0, name=name, media_type=kind, data=text.encode())

    def metadata(self, values: Mapping[str, str]) -> None:
        """Write facts by their names."""
        self._writer.write_metadata("robotskin", dict(values))

    def flush(self) -> None:
        """End the chunk: what was logged before survives a kill."""
        self._writer.flush()

    def close(self) -> None:
        """End the file as a whole one."""
        self._writer.close()


def _schema(message: Message) -> Any:
    return foxglove.Schema(name=message.schema_name, encoding="protobuf", data=message.descriptor())
