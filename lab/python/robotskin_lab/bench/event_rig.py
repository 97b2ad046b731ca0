# SPDX-License-Identifier: Apache-2.0
"""A skinned robot whose section units talk to a driver in this process, and what they send while palms lie on it."""

from __future__ import annotations

import time
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from robotskin.driver import Driver
from robotskin.layout import Layout
from robotskin.robots import Robot
from robotskin.world import World
from robotskin_lab.bench.stimulus import ACTIVE_SHARE, Palms, palms, places

POSTURE = {"ur5": [0.0, -1.2, 1.4, -1.5, -1.5, 0.0]}
SETTLE_S = 1.5  # palms come near from 8 cm with at most 25 cm/s and then press


@dataclass
class Uplink:
    """What the section units sent in one mode: datagrams, sample frames a cell, what was lost, how long it took.

    frames: (N,) sample frames of each cell at the host. active: (T) cells active at once, each 50 ms. dropped: frames
    that found no room on their way.
    """

    datagrams: list[tuple[int, int, bytes]]
    frames: NDArray[np.int64]
    active: NDArray[np.int64]
    dropped: int
    seconds: float

    @property
    def frames_per_s(self) -> float:
        """Sample frames of all cells each second."""
        return float(self.frames.sum()) / self.seconds

    @property
    def bytes_per_s(self) -> float:
        """Datagram bytes each second."""
        return sum(len(datagram) for _, _, datagram in self.datagrams) / self.seconds

    @property
    def cells_active(self) -> int:
        """The least number of cells that were active at once."""
        return int(self.active.min())


class Rig:
    """World, driver, and as many palms as make `cells_active` cells active (none with 0)."""

    def __init__(self, robot: Robot, layout: Layout, seed: int, cells_active: int = 0) -> None:
        self.places = palm_places(robot, layout, seed, cells_active)
        self.seed = seed
        posture = POSTURE.get(layout.robot)
        self.world = World(layout, robot, seed, posture=posture, hands=palms(len(self.places)))
        self.driver = Driver(layout.skin_model(), session_seed=seed)
        self.groups = sorted(set(layout.group.tolist()))
        while not self.driver.samples()["seen"].all():
            self._step()
            if self.world.time_s > 5:
                raise RuntimeError("the network did not form within 5 s")
        self._at_rest = self._rest()

    def _step(self) -> list[tuple[int, int, bytes]]:
        self.world.step(0.001)
        taken = self.world.take_datagrams()
        for _, when_ns, datagram in taken:
            self.driver.handle(datagram, when_ns)
        self.driver.publish(self.world.now_ns)
        for group, unit, datagram in self.driver.downlink(self.world.now_ns):
            self.world.post(group, unit, datagram)
        return taken

    def run(self, seconds: float, touch: Palms | None = None) -> None:
        """Let time pass."""
        for _ in range(round(1000 * seconds)):
            if touch is not None:
                touch.drive(self.world.time_s)
            self._step()

    def set_mode(self, event: bool, mask: int) -> None:
        """Switch every cell, and let the change reach it."""
        for group in self.groups:
            self.driver.command("event_mask", mask, group=group)
            self.driver.command("mode", int(event), group=group)
        self.run(0.5)

    def release(self) -> None:
        """All palms leave."""
        self.world.release()
        self.run(SETTLE_S)

    def touch(self, moving: float, settle_s: float = SETTLE_S) -> Palms:
        """All palms come, and `moving` of them rub; back when they lie and the robot stands still again."""
        touch = Palms(self.world, self.places, self.seed, moving)
        self.run(settle_s, touch)
        return touch

    def measure(self, seconds: float, touch: Palms | None = None) -> Uplink:
        """Run and keep what the section units send."""
        before, dropped = self._frames(), self.world.network.frames_dropped
        datagrams, active = [], []
        for step in range(round(1000 * seconds)):
            if touch is not None:
                touch.drive(self.world.time_s)
            datagrams += self._step()
            if step % 50 == 0:
                active.append(self._active())
        dropped = self.world.network.frames_dropped - dropped
        return Uplink(datagrams, self._frames() - before, np.array(active), dropped, seconds)

    def _frames(self) -> NDArray[np.int64]:
        samples = self.driver.samples()
        return samples["clock_frames"].astype(np.int64) + samples["event_frames"]

    def _rest(self) -> tuple[NDArray[np.int64], NDArray[np.int64]]:
        """Proximity (N) and forces (N, 3) in counts: the zero of sensors that carry a load without touch."""
        samples = self.driver.samples()
        return samples["proximity"].astype(np.int64), samples["force"].astype(np.int64)

    def _active(self) -> int:
        proximity, force = (now - rest for now, rest in zip(self._rest(), self._at_rest, strict=True))
        return int(((proximity > ACTIVE_SHARE * 65536) | (force > ACTIVE_SHARE * 1024).any(axis=1)).sum())


def palm_places(robot: Robot, layout: Layout, seed: int, cells_active: int) -> list[int]:
    """Where palms lie that make about `cells_active` cells active."""
    if cells_active == 0:
        return []
    bare = World(layout, robot, seed, posture=POSTURE.get(layout.robot), hands=(), powered=False)
    return places(bare.base_from_cell(), cells_active)


def driver_cpu_percent(layout: Layout, traffic: Uplink) -> float:
    """Processor time that a driver takes for this traffic, in percent of one core; the best of three."""
    best = np.inf
    for _ in range(3):
        driver = Driver(layout.skin_model(), session_seed=1)
        start = time.process_time()
        for _, when_ns, datagram in traffic.datagrams:
            driver.handle(datagram, when_ns)
            driver.publish(when_ns)
        best = min(best, time.process_time() - start)
    return 100 * best / traffic.seconds
