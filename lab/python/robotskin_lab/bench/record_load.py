# SPDX-License-Identifier: Apache-2.0
"""The load of the largest published skin through driver, reader and recorder, without simulating its cells."""

from __future__ import annotations

import dataclasses
import hashlib
import time
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from robotskin import layout
from robotskin.driver import Driver
from robotskin.layout import Layout
from robotskin.loop import SkinLoop
from robotskin.record import Recorder
from robotskin.skin import SkinReader, SkinState
from robotskin_lab._lab.traffic import Traffic
from robotskin_lab.bench.driver import connected

COLUMNS = ("normal_force", "proximity", "distance", "acceleration", "temperature", "stamp_ns", "health", "saturated")
TICK_NS = 1_000_000


@dataclass
class Loaded:
    """What was recorded, and a digest of every skin state that was read, by its time."""

    digests: dict[int, bytes]
    frames: int
    dropped: int
    recorder_cpu_s: float


@dataclass
class Rig:
    """A driver under load, its reader, and what a recorder asks of a session."""

    driver: Driver
    traffic: Traffic
    reader: SkinReader
    layout: Layout
    now_ns: int
    loop: SkinLoop | None = None

    @classmethod
    def of(cls, robot: str, seed: int, **of_traffic: Any) -> Rig:
        """Connected; the cells are those of a robot's finished skin, under the keys of the traffic.

        of_traffic: what `Traffic` takes.
        """
        worn = layout.finished(robot)
        driver, traffic, now_ns = connected(len(worn), seed, **of_traffic)
        keys = np.array(traffic.keys(), np.int64)
        worn = dataclasses.replace(worn, group=(keys >> 16).astype(np.uint16), id=(keys & 0xFFFF).astype(np.uint16))
        return cls(driver, traffic, SkinReader(driver, worn.skin_model()), worn, now_ns)

    def tick(self, state: SkinState) -> None:
        """A millisecond of the load."""
        self.now_ns += TICK_NS
        for datagram in self.traffic.step(self.now_ns):
            self.driver.handle(datagram, self.now_ns)
        self.driver.publish(self.now_ns)
        for _, _, datagram in self.driver.downlink(self.now_ns):
            self.traffic.hear(datagram)
        self.reader.read(self.now_ns, state)


def digest(state: SkinState) -> bytes:
    """Of every value of a skin state."""
    found = hashlib.blake2b(digest_size=16)
    for name in COLUMNS:
        found.update(np.ascontiguousarray(getattr(state, name)).data)
    return found.digest()


def loaded(path: Path, seconds: float, seed: int, robot: str = "talos") -> Loaded:
    """Record a load for a time, no faster than the wall clock."""
    rig = Rig.of(robot, seed)
    state = SkinState(len(rig.layout))
    digests: dict[int, bytes] = {}
    before = rig.traffic.frames
    with Recorder(path, rig) as recorder:
        cpu_s = recorder.cpu_s
        began = time.monotonic()
        for tick in range(round(seconds * 1e3)):
            rig.tick(state)
            digests[rig.now_ns] = digest(state)
            ahead_s = (tick + 1) * 1e-3 - (time.monotonic() - began)
            if ahead_s > 0:
                time.sleep(ahead_s)
        recorder.drain()
        used_s = recorder.cpu_s - cpu_s
        dropped = recorder.dropped
    return Loaded(digests, rig.traffic.frames - before, dropped, used_s)
