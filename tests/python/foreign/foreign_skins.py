# SPDX-License-Identifier: Apache-2.0
"""Small skins of other makers, made here: a taxel file, declarations, frames as their sensors would send them."""

import binascii
import threading

import numpy as np

from robotskin.foreign import Channel, Declared, Source
from robotskin.layout import Layout

TRIANGLES, SLOTS = 4, 12
PADS = (6, 10)


def taxel_text(random: np.random.Generator, *, normals: str = "given", body: str = "forearm_link") -> str:
    """Four triangles around a tube of 60 mm radius in the form of the iCub's files; slots 6 and 10 are no taxels."""
    rows = []
    for triangle in range(TRIANGLES):
        around = 2 * np.pi * triangle / TRIANGLES
        for slot in range(SLOTS):
            if slot in PADS:
                rows.append(np.zeros(6))
                continue
            turn = around + 0.08 * (slot % 4 - 1.5) + random.normal(0, 1e-3)
            out = np.array([np.cos(turn), np.sin(turn), 0.0])
            place = np.array([0.0, 0.0, 0.15 + 0.008 * (slot // 4)]) + 0.06 * out
            normal = {"given": out, "placeholder": np.array([1.0, 0, 0]), "none": np.zeros(3)}[normals]
            rows.append(np.concatenate([place, normal]))
    used = " ".join("-2" if i % SLOTS in PADS else str(i) for i in range(TRIANGLES * SLOTS))
    body_rows = "\n".join(" ".join(f"{value:.6f}" for value in row) for row in rows)
    return f"name {body}\nspatial_sampling taxel\ntaxel2Repr ( {used} )\n[calibration]\n{body_rows}\n"


def declared(kind: str = "python", at: str = "made", **further) -> Declared:
    """Forces of one count a slot, 0.01 N each from 20 on, 100 times a second."""
    channel = Channel("force", scale=0.01, zero=20.0, lowest=0.0, highest=4095.0)
    return Declared((Source(kind, at, TRIANGLES * SLOTS, **further),), (channel,), 100.0)


def frame(source: Source, counts: np.ndarray, number: int) -> bytes:
    """A binary frame of u16 counts, as `source` declares it."""
    order = {"little": "<", "big": ">"}[source.byte_order]
    sequence = int(source.sequence[1:] or 0) // 8 if source.sequence else 0
    body = source.start + (number % 256**sequence).to_bytes(sequence, source.byte_order)
    body += counts.astype(f"{order}u2").tobytes()
    if source.check == "sum8":
        return body + bytes([sum(body) & 0xFF])
    return body + (binascii.crc_hqx(body, 0xFFFF).to_bytes(2, source.byte_order) if source.check == "crc16" else b"")


class Pads:
    """What the sensor of such a skin yields: rest, with noise, and a touch that is set from outside."""

    def __init__(self, seed: int, slots: int = TRIANGLES * SLOTS) -> None:
        self.random, self.touch = np.random.default_rng(seed), np.zeros(slots)
        self.ending = threading.Event()

    def __iter__(self):
        while not self.ending.is_set():
            yield 20 + self.touch + self.random.integers(-1, 2, len(self.touch))


def cell_of(layout: Layout, slot: int) -> int:
    """Index of the cell at a slot."""
    return int(np.flatnonzero(np.asarray(layout.id) == slot + 1)[0])
