# SPDX-License-Identifier: Apache-2.0
"""The entries of a tape's block, as core/record/tape.hpp defines them."""

from __future__ import annotations

import struct

from robotskin.errors import RobotskinError

HEADER = struct.Struct("<IHHq")


class RecordError(RobotskinError):
    """A recording that cannot be written or read; the message names the file and what to do."""


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


def first_time_ns(block: bytes) -> int:
    """Of a block that is not empty."""
    return int(HEADER.unpack_from(block, 0)[3])
