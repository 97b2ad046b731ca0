# SPDX-License-Identifier: Apache-2.0
"""Damaged and lying recordings, made of a whole one: every type of record, and what its bytes mean, is drawn anew."""

from __future__ import annotations

import io
import json
import random
import struct
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from mcap.records import Attachment, Channel, Message, Metadata
from mcap.writer import CompressionType, IndexType, Writer

from robotskin.record.mcap_file import MAGIC, records
from robotskin.record.record_copy import RecordCopy

LIES = (0, 1, 7, 8, 16, 255, 2**16, 2**31 - 1, 2**31, 2**32 - 1, 2**40, 2**63 - 1, 2**63, 2**64 - 1)
OPCODES = range(0x01, 0x10)
RECORD = struct.Struct("<BQ")
NUMBERS: tuple[Any, ...] = (0, -1, 1e308, -1e308, 2**63, 1e-300, "NaN", None, [], {}, "", True)


@dataclass(frozen=True)
class Parts:
    """What a whole recording holds: its records, those of chunks one by one, and the file as it is."""

    records: tuple[Any, ...]
    whole: bytes

    @classmethod
    def of(cls, path: Path) -> Parts:
        """Read. Raises RecordingFileError."""
        return cls(tuple(records(path)), path.read_bytes())


def hostile(parts: Parts, draw: random.Random) -> bytes:
    """One file."""
    kind = draw.randrange(10)
    if kind == 0:
        return _bytes_anywhere(parts.whole, draw)
    if kind == 1:
        return _foreign(parts.whole, draw)
    compression = draw.choice((CompressionType.NONE, CompressionType.NONE, CompressionType.LZ4, CompressionType.ZSTD))
    if kind < 5:  # the framing lies; no check sum tells
        plain = _written(parts.records, compression, checked=False)
        for _ in range(draw.randrange(1, 4)):
            plain = draw.choice((_sizes_lie, _bytes_anywhere, _one_type, _cut))(plain, draw)
        return plain
    changed = list(parts.records)  # what is framed rightly lies
    for _ in range(draw.randrange(1, 6)):
        at = draw.randrange(len(changed))
        # Facts and attachments are few among the messages.
        rare = [index for index, one in enumerate(changed) if not isinstance(one, Message)]
        if draw.random() < 0.5:
            at = draw.choice(rare)
        changed[at] = _changed(changed[at], draw)
        if draw.random() < 0.1:
            del changed[at]
        elif draw.random() < 0.1:
            changed.insert(draw.randrange(len(changed)), changed[at])
    return _written(changed, compression, checked=draw.random() < 0.5)


# ---- What stands in a record ----


def _changed(record: Any, draw: random.Random) -> Any:
    if isinstance(record, Message):
        data = draw.choice((_bytes_anywhere, _cut, _grown, _entries_lie, _fields_lie))(record.data, draw)
        time = draw.choice(LIES) if draw.random() < 0.1 else record.log_time
        return Message(record.channel_id, time, data, record.publish_time, record.sequence)
    if isinstance(record, Attachment):
        change = draw.choice((_bytes_anywhere, _cut, _json_lies, _json_lies, _json_lies))
        return Attachment(
            record.create_time, record.log_time, record.name, record.media_type, change(record.data, draw)
        )
    if isinstance(record, Metadata):
        facts = dict(record.metadata)
        name = draw.choice(sorted(facts)) if facts else "none"
        facts[name] = draw.choice(("", "\0", "9" * 400, "-1", "nan", "[", "{}", "ü" * 70, "1e99"))
        if draw.random() < 0.4:
            facts.pop(name)
        return Metadata(record.name, facts)
    if isinstance(record, Channel):
        topic = draw.choice(("/skin/tape", "/control/tape", "/skin/samples", "/operator", "", "/none"))
        return Channel(record.id, topic, record.message_encoding, record.metadata, record.schema_id)
    return record


def _entries_lie(data: bytes, draw: random.Random) -> bytes:
    """An entry of a tape says another size, kind or time; behind a message's own two numbers."""
    out = bytearray(data)
    at = 3 + 8 * draw.randrange(max(len(out) // 8, 1))
    form, value = draw.choice((("<I", draw.choice(LIES) & 0xFFFFFFFF), ("<H", draw.randrange(20)),
                               ("<Q", draw.choice(LIES))))  # fmt: skip
    if at + struct.calcsize(form) <= len(out):
        struct.pack_into(form, out, at, value)
    return bytes(out)


def _fields_lie(data: bytes, draw: random.Random) -> bytes:
    """A field of protobuf with another number, type or size before all others."""
    tag, size = draw.randrange(256), bytes(draw.randrange(256) for _ in range(draw.randrange(1, 11)))
    return bytes([tag]) + size + data


def _json_lies(data: bytes, draw: random.Random) -> bytes:
    """Something in it is another number, another type, longer, or missing."""
    try:
        told = json.loads(data)
    except ValueError:
        return _bytes_anywhere(data, draw)
    places: list[tuple[Any, Any]] = []

    def walk(node: Any) -> None:
        for key, inner in list(node.items()) if isinstance(node, dict) else list(enumerate(node)):
            places.append((node, key))
            if isinstance(inner, dict | list):
                walk(inner)

    if isinstance(told, dict | list):
        walk(told)
    if places:
        node, key = draw.choice(places)
        what = draw.randrange(4)
        if what == 0:
            del node[key]
        elif what == 1 and isinstance(node[key], list):
            node[key] = node[key] * draw.randrange(2, 50)
        else:
            node[key] = draw.choice(NUMBERS)
    return json.dumps(told).encode()


# ---- How it is framed ----


def _written(kept: Any, compression: CompressionType, checked: bool) -> bytes:
    out = io.BytesIO()
    writer = Writer(out, chunk_size=1 << 18, compression=compression, index_types=IndexType.ALL, enable_crcs=checked)
    writer.start("", library="robotskin")
    copy = RecordCopy(writer)
    for record in kept:
        copy.put(record)
    writer.finish()
    return out.getvalue()


def _places(data: bytes) -> list[tuple[int, int, int]]:
    """(where it begins, type, size) of each record of the file, as far as that is to be told."""
    found, at = [], len(MAGIC)
    while at + RECORD.size <= len(data):
        opcode, size = RECORD.unpack_from(data, at)
        found.append((at, opcode, size))
        at += RECORD.size + size
    return found


def _sizes_lie(data: bytes, draw: random.Random) -> bytes:
    """The size of a record, or a number within it, is another."""
    out, places = bytearray(data), _places(data)
    at, _, size = draw.choice(places)
    where = at + 1 if draw.random() < 0.4 else at + RECORD.size + draw.randrange(max(min(size, 120), 1))
    form = draw.choice(("<Q", "<I"))
    value = draw.choice((*LIES, size - 1, size + 1, len(data))) % 2 ** (8 * struct.calcsize(form))
    if where + struct.calcsize(form) <= len(out):
        struct.pack_into(form, out, where, value)
    return bytes(out)


def _one_type(data: bytes, draw: random.Random) -> bytes:
    """Random bytes in records of one drawn type, or its type itself is another."""
    out, places = bytearray(data), _places(data)
    opcode = draw.choice(sorted({place[1] for place in places}))
    for at, _, size in (place for place in places if place[1] == opcode):
        if draw.random() < 0.2:
            out[at] = draw.choice(OPCODES)
        for _ in range(draw.randrange(1, 5)):
            where = at + RECORD.size + draw.randrange(max(size, 1))
            if where < len(out):
                out[where] = draw.randrange(256)
    return bytes(out)


def _bytes_anywhere(data: bytes, draw: random.Random) -> bytes:
    out = bytearray(data)
    for _ in range(draw.randrange(1, 40) if out else 0):
        out[draw.randrange(len(out))] = draw.randrange(256)
    return bytes(out)


def _cut(data: bytes, draw: random.Random) -> bytes:
    """Cut; sometimes with an end as if it were whole."""
    at = draw.randrange(len(data) + 1)
    return data[:at] + (MAGIC if draw.random() < 0.3 else b"")


def _grown(data: bytes, draw: random.Random) -> bytes:
    return data + draw.randbytes(draw.randrange(1, 200))


def _foreign(whole: bytes, draw: random.Random) -> bytes:
    """What is no recording at all."""
    makers: tuple[Callable[[], bytes], ...] = (
        lambda: draw.randbytes(draw.randrange(2000)),
        lambda: MAGIC + draw.randbytes(draw.randrange(2000)) + MAGIC,
        lambda: MAGIC,
        lambda: whole[: draw.randrange(9)],
        lambda: MAGIC + RECORD.pack(draw.choice(OPCODES), draw.choice(LIES)) + draw.randbytes(100) + MAGIC,
        lambda: whole + whole,
        lambda: whole[len(whole) // 2 :] + whole[: len(whole) // 2],
    )
    return draw.choice(makers)()
