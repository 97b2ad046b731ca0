# SPDX-License-Identifier: Apache-2.0
"""MCAP files as they may come from anywhere: records one by one, in bounded memory, up to the first that is damaged."""

from __future__ import annotations

import io
import os
import struct
from collections.abc import Iterator
from pathlib import Path

import lz4.frame
import zstandard
from mcap.exceptions import McapError
from mcap.reader import make_reader
from mcap.records import Channel, Chunk, McapRecord, Schema
from mcap.stream_reader import StreamReader, breakup_chunk

from robotskin.errors import RobotskinError

RECORD_BYTES_MAX = 256 << 20
CHUNK_BYTES_MAX = 256 << 20
DAMAGE = (
    McapError, RobotskinError, ValueError, struct.error, EOFError, MemoryError, OverflowError, KeyError, RuntimeError,
    OSError, zstandard.ZstdError,
)  # fmt: skip
"""What readers raise on damaged bytes: their own errors, and what numbers that lie lead to."""


class RecordingFileError(RobotskinError):
    """A file that is no recording, or a damaged one; the message names the file, the place and what to do."""


class BoundedFile(io.BufferedReader):
    """A file for readers that believe sizes: what would pass its end, or a record's bound, is a ValueError.

    Raises OSError where it cannot be opened.
    """

    def __init__(self, path: Path) -> None:
        super().__init__(io.FileIO(path))
        self._size = os.fstat(self.fileno()).st_size

    def read(self, size: int | None = -1, /) -> bytes:
        """At most what a record may hold, and never more memory than the file has bytes left."""
        if size is None or size < 0 or size > RECORD_BYTES_MAX:
            raise ValueError(f"{size} bytes are said to follow, at most {RECORD_BYTES_MAX} are read")
        return super().read(min(size, max(self._size - self.tell(), 0)))

    def seek(self, target: int, whence: int = os.SEEK_SET, /) -> int:
        """Within the file."""
        if whence == os.SEEK_SET and not 0 <= target <= self._size:
            raise ValueError(f"an index names byte {target} of {self._size}")
        return super().seek(target, whence)


def unpacked(chunk: Chunk) -> list[McapRecord]:
    """The records of a chunk. Raises one of `DAMAGE` where it says less than it holds."""
    if chunk.uncompressed_size > CHUNK_BYTES_MAX:
        raise ValueError(f"a chunk of {chunk.uncompressed_size} bytes, at most {CHUNK_BYTES_MAX} are read")
    size = chunk.uncompressed_size
    if chunk.compression == "zstd":
        data = zstandard.ZstdDecompressor().stream_reader(chunk.data).read(size + 1)
    elif chunk.compression == "lz4":
        decompressor = lz4.frame.LZ4FrameDecompressor()
        data = decompressor.decompress(chunk.data, max_length=size + 1)
    elif chunk.compression == "":
        data = chunk.data
    else:
        raise ValueError(f"compression {chunk.compression!r}, known are zstd and lz4")
    if len(data) != size:
        raise ValueError(f"a chunk says {size} bytes and holds {'more' if len(data) > size else len(data)}")
    plain = Chunk(
        compression="", data=data, message_start_time=chunk.message_start_time, message_end_time=chunk.message_end_time,
        uncompressed_crc=chunk.uncompressed_crc, uncompressed_size=size,
    )  # fmt: skip
    return breakup_chunk(plain, validate_crc=True)


class Damaged(McapRecord):
    """Stands in the place of a chunk whose bytes are damaged."""


def records(path: Path, *, skip_damaged: bool = False) -> Iterator[McapRecord]:
    """Every record in the order of the file, those of chunks one by one; ends quietly at the first damage.

    skip_damaged: of a chunk that is damaged within, a `Damaged` comes, and what follows it.

    Raises:
        RecordingFileError: the file cannot be opened, or does not begin as MCAP does.
    """
    try:
        file = BoundedFile(path)
    except OSError as error:
        raise RecordingFileError(f"{path}: {error.strerror}") from error
    with file:
        if file.read(8) != b"\x89MCAP0\r\n":
            raise RecordingFileError(f"{path}: no MCAP file; recordings are made by `robotskin record`")
        file.seek(0)
        reader = iter(StreamReader(file, emit_chunks=True, record_size_limit=RECORD_BYTES_MAX).records)
        while True:
            try:
                record = next(reader)
            except StopIteration:
                return
            except DAMAGE:
                return
            try:
                inner = unpacked(record) if isinstance(record, Chunk) else [record]
            except DAMAGE:
                if not skip_damaged:
                    return
                inner = [Damaged()]
            yield from inner


def declared(path: Path) -> list[Schema | Channel]:
    """Schemas, then channels, that the summary at the end of a file repeats; none where it is cut off or damaged."""
    try:
        with BoundedFile(path) as file:
            summary = make_reader(file).get_summary()
    except DAMAGE:
        return []
    return [] if summary is None else [*summary.schemas.values(), *summary.channels.values()]


MAGIC = b"\x89MCAP0\r\n"


def require_file(path: Path) -> None:
    """Refuse what is no file. Raises RecordingFileError, which says what to name instead."""
    if path.is_dir():
        inside = ", ".join(one.name for one in sorted(path.glob("*.mcap"))[:3])
        such = f", such as {inside}" if inside else ""
        raise RecordingFileError(f"{path}: is a folder; name a recording in it{such}")
    if not path.is_file():
        raise RecordingFileError(f"{path}: no such file; `robotskin record {path}` makes a recording")


def is_mcap(path: Path) -> bool:
    """Whether the file begins as an MCAP file does."""
    with path.open("rb") as file:
        return file.read(len(MAGIC)) == MAGIC


def is_whole(path: Path) -> bool:
    """Whether the file ends as a finished one does: footer and magic bytes."""
    with path.open("rb") as file:
        file.seek(0, 2)
        if file.tell() < 16:
            return False
        file.seek(-8, 2)
        return file.read(8) == MAGIC


__all__ = [
    "BoundedFile",
    "RecordingFileError",
    "declared",
    "is_mcap",
    "is_whole",
    "records",
    "require_file",
    "unpacked",
]
