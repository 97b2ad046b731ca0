# SPDX-License-Identifier: Apache-2.0
"""A skin of another maker that is made: taxels in the form of the iCub's files, and frames of their counts."""

from __future__ import annotations

import binascii

import numpy as np
from numpy.typing import NDArray

from robotskin.foreign import Source

RATE_HZ = 100.0
NEWTON, ZERO = 0.01, 200.0
"""A count, and counts at rest."""
SLOTS, PADS = 12, (6, 10)
"""Of a triangle; two of its slots measure the temperature."""
RADIUS_M, ALONG_M = 0.06, (0.08, 0.30)
ROWS = 6


def made_taxels(random: np.random.Generator, triangles: int, body: str = "forearm_link") -> str:
    """The text of a taxel file: triangles of ten taxels each in six rows around a tube."""
    rows = []
    columns = -(-triangles // ROWS)
    for triangle in range(triangles):
        around = 2 * np.pi * (triangle % columns) / columns
        along = np.interp(triangle // columns, (0, ROWS - 1), ALONG_M)
        for slot in range(SLOTS):
            turn = around + 0.08 * (slot % 4 - 1.5) + random.normal(0, 1e-3)
            out = np.array([np.cos(turn), np.sin(turn), 0.0])
            place = np.array([0.0, 0.0, along + 0.006 * (slot // 4)]) + RADIUS_M * out
            rows.append(np.zeros(6) if slot in PADS else np.concatenate([place, out]))
    used = " ".join("-2" if i % SLOTS in PADS else str(i) for i in range(triangles * SLOTS))
    table = "\n".join(" ".join(f"{value:.6f}" for value in row) for row in rows)
    return f"name {body}\nspatial_sampling taxel\ntaxel2Repr ( {used} )\n[calibration]\n{table}\n"


def frame_of(source: Source, counts: NDArray[np.float64], number: int) -> bytes:
    """A binary frame of u16 counts with a sequence number of 8 bits and CRC16."""
    body = source.start + bytes([number % 256]) + np.clip(np.rint(counts), 0, 65535).astype("<u2").tobytes()
    return body + binascii.crc_hqx(body, 0xFFFF).to_bytes(2, "little")
