# SPDX-License-Identifier: Apache-2.0
"""What a recorder's tapes and its samples are in a fleet: messages in the form of recordings."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from robotskin.record.messages import SKIN_SAMPLES, Field, Message

EVENT_FLAG = 1

TAPE = Message(
    "Tape",
    "the next blocks of a recorder's two tapes",
    (Field("driver", "bytes", "of the driver's thread"), Field("control", "bytes", "of the control thread")),
)


def events_in(samples: Mapping[str, bytes]) -> bytes:
    """The samples that cells sent because something changed, as a message of `SKIN_SAMPLES`; empty where none is.

    Joined to others it stays one: fields of protobuf that come twice are one after the other.
    """
    flags = np.frombuffer(samples.get("flags", b""), "<u4")
    found = np.flatnonzero(flags & EVENT_FLAG)
    if not len(found):
        return b""
    columns = {}
    for name, raw in samples.items():
        width = len(raw) // len(flags)
        columns[name] = np.frombuffer(raw, np.uint8).reshape(len(flags), width)[found].tobytes()
    return SKIN_SAMPLES.pack(columns)
