# SPDX-License-Identifier: Apache-2.0
"""The samples in recorded states of skins without our driver (core/record/felt_state.hpp)."""

from __future__ import annotations

import struct

import numpy as np
from numpy.typing import NDArray

from robotskin import firmware

HEADER = struct.Struct("<IIqq")


class FeltSamples:
    """Finds what is new from one state of a skin to the next; `key` (N) of its cells, group << 16 | id."""

    def __init__(self, key: NDArray[np.uint32]) -> None:
        self._key = key
        self._stamp_ns = np.zeros(len(key), np.int64)

    def new_in(self, payload: bytes) -> dict[str, NDArray]:
        """The new samples, by the fields of `SKIN_SAMPLES`; a sensor that the skin lacks is left out."""
        sensors, cells, _, _ = HEADER.unpack_from(payload)
        at = HEADER.size
        columns: dict[str, NDArray] = {}
        for bit, (_, column, channels, _, _) in enumerate(firmware.SENSORS):
            if sensors >> bit & 1:
                columns[column] = np.frombuffer(payload, "<f4", cells * channels, at).reshape(cells, channels)
                at += 4 * cells * channels
        if "proximity" in columns:
            at += 4 * cells
        stamp_ns = np.frombuffer(payload, "<i8", cells, at)
        new = stamp_ns != self._stamp_ns
        self._stamp_ns = stamp_ns.copy()
        found = {"key": self._key[new], "stamp_ns": stamp_ns[new], "flags": np.zeros(int(new.sum()), np.uint32)}
        return found | {column: values[new] for column, values in columns.items()}
