# SPDX-License-Identifier: Apache-2.0
"""Frames out of foreign bytes: counts of every slot, as declared. No byte makes it fail: what is none is counted."""

from __future__ import annotations

import binascii
import math
from dataclasses import dataclass
from typing import Literal

import numpy as np
from numpy.typing import NDArray

from robotskin.foreign.declared import CHECK_BYTES, Declared, Source, bytes_of

Counts = NDArray[np.float64]
"""(slots, values) of a frame; NaN: no value."""


@dataclass
class Tally:
    """What came. frames: whole ones; lost: by their sequence numbers; bad: with a wrong check sum, length or text;
    skipped_bytes: that began no frame; refused: datagrams of another sender."""

    frames: int = 0
    lost: int = 0
    bad: int = 0
    skipped_bytes: int = 0
    refused: int = 0


class BinaryFrames:
    """Binary frames: start, sequence, slots × values numbers, check sum over all before it."""

    def __init__(self, source: Source, values: int, tally: Tally) -> None:
        self._source, self._tally = source, tally
        order = {"little": "<", "big": ">"}[source.byte_order]
        self._dtype = np.dtype(f"{order}{source.number[0]}{bytes_of(source.number)}")
        self._shape = (source.slots, values)
        self._sequence_bytes = bytes_of(source.sequence)
        self._check_bytes = CHECK_BYTES[source.check]
        self._head = len(source.start) + self._sequence_bytes
        self.size = source.frame_bytes(values)
        """Bytes of a frame."""
        self._kept = bytearray()
        self._expected: int | None = None

    def feed(self, data: bytes) -> list[Counts]:
        """The frames that end with these bytes of a stream."""
        self._kept += data
        found: list[Counts] = []
        while True:
            at = self._kept.find(self._source.start) if self._source.start else 0
            if at < 0:
                # What may be the beginning of a start stays.
                at = max(len(self._kept) - len(self._source.start) + 1, 0)
                self._skip(at)
                return found
            self._skip(at)
            if len(self._kept) < self.size:
                return found
            counts = self.whole(bytes(self._kept[: self.size]))
            if counts is None:
                self._skip(1)
                continue
            del self._kept[: self.size]
            found.append(counts)

    def whole(self, frame: bytes) -> Counts | None:
        """The counts of one frame; None, and counted, for bytes that are none."""
        body = memoryview(frame)[: len(frame) - self._check_bytes]
        if len(frame) != self.size or not frame.startswith(self._source.start) or not self._checks(frame, body):
            self._tally.bad += 1
            return None
        self._follow(int.from_bytes(frame[len(self._source.start) : self._head], self._order))
        self._tally.frames += 1
        numbers = np.frombuffer(body, self._dtype, offset=self._head).reshape(self._shape)
        if self._dtype.kind != "f":
            return numbers.astype(np.float64)
        with np.errstate(invalid="ignore"):  # bytes that are no number stay none
            return numbers.astype(np.float64)

    @property
    def _order(self) -> Literal["little", "big"]:
        return "little" if self._source.byte_order == "little" else "big"

    def _checks(self, frame: bytes, body: memoryview) -> bool:
        told = int.from_bytes(frame[len(body) :], self._order)
        if self._source.check == "sum8":
            return sum(body) & 0xFF == told
        return self._source.check == "none" or binascii.crc_hqx(body, 0xFFFF) == told

    def _follow(self, sequence: int) -> None:
        if not self._sequence_bytes:
            return
        turn = 1 << (8 * self._sequence_bytes)
        if self._expected is not None:
            self._tally.lost += (sequence - self._expected) % turn
        self._expected = (sequence + 1) % turn

    def _skip(self, count: int) -> None:
        self._tally.skipped_bytes += count
        del self._kept[:count]


class TextFrames:
    """Lines of numbers, a frame each, parted by commas, blanks or semicolons. An empty or `nan` field: no value."""

    LINE_MAX = 4_000_000

    def __init__(self, slots: int, values: int, tally: Tally, leading: tuple[int, ...] = (0,)) -> None:
        self._shape, self._tally, self._leading = (slots, values), tally, leading
        self._kept = bytearray()

    def feed(self, data: bytes) -> list[Counts]:
        """The frames that end with these bytes of a stream."""
        self._kept += data
        *lines, rest = bytes(self._kept).split(b"\n")
        self._kept = bytearray(rest)
        if len(self._kept) > self.LINE_MAX:
            self._tally.bad += 1
            self._kept.clear()
        found = [self.line(line.decode("ascii", "replace")) for line in lines if line.strip()]
        return [frame[1] for frame in found if frame is not None]

    def line(self, text: str) -> tuple[list[float], Counts] | None:
        """The numbers before a frame, such as its time, and its counts; None, and counted, for a line that is none."""
        numbers = _numbers(text)
        size = self._shape[0] * self._shape[1]
        if numbers is None or len(numbers) - size not in self._leading:
            self._tally.bad += 1
            return None
        before = len(numbers) - size
        self._tally.frames += 1
        return numbers[:before], np.array(numbers[before:]).reshape(self._shape)


def decoder_of(source: Source, declared: Declared, tally: Tally) -> BinaryFrames | TextFrames:
    """What makes frames of this source's bytes."""
    values = declared.values
    if source.encoding == "binary":
        return BinaryFrames(source, values, tally)
    return TextFrames(source.slots, values, tally)


def _numbers(text: str) -> list[float] | None:
    words = text.replace("(", " ").replace(")", " ").strip()
    parts = words.replace(";", ",").split(",") if "," in words or ";" in words else words.split()
    try:
        return [float(part) if part.strip() else math.nan for part in parts]
    except ValueError:
        return None
