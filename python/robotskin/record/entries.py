# SPDX-License-Identifier: Apache-2.0
"""The entries of a tape's block, as core/record/tape.hpp defines them."""

from __future__ import annotations

import struct
from typing import NamedTuple

from robotskin.errors import RobotskinError

HEADER = struct.Struct("<IHHq")
ENDED_BY_CLOCK = 1
"""A flag of a command: a clock ended the fusion of its tick."""


class RecordError(RobotskinError):
    """A recording that cannot be written or read; the message names the file and what to do."""


class TapeEntry(NamedTuple):
    """One entry: its kind by number, its time in ns, its bytes, and flags such as `ENDED_BY_CLOCK`."""

    kind: int
    time_ns: int
    payload: bytes
    flags: int


def entries(block: bytes) -> list[TapeEntry]:
    """Each entry of a tape's block. Raises RecordError for bytes that are none."""
    out = []
    at = 0
    while at < len(block):
        if len(block) - at < HEADER.size:
            raise RecordError("recording: a block ends within an entry")
        size, kind, flags, time_ns = HEADER.unpack_from(block, at)
        at += HEADER.size
        if size > len(block) - at:
            raise RecordError(f"recording: an entry of {size} bytes passes its block")
        out.append(TapeEntry(kind, time_ns, block[at : at + size], flags))
        at += (size + 7) // 8 * 8
    return out


def first_time_ns(block: bytes) -> int:
    """Of a block that is not empty."""
    return int(HEADER.unpack_from(block, 0)[3])
