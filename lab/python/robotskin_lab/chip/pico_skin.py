# SPDX-License-Identifier: Apache-2.0
"""An emulated Pico in a skin: section unit at its port 1, chains of host-built cells behind the others.

All of it runs in the Pico's own microseconds.
"""

from __future__ import annotations

import heapq
from collections.abc import Callable, Sequence
from functools import partial

from robotskin.choices import MODES
from robotskin.driver import Driver
from robotskin_lab import firmware
from robotskin_lab.chip.emulated_pico import EmulatedPico

SAMPLE_FRAMES = frozenset(MODES)
"""Types of frames that hold a sample: they are called as the mode in which a cell sends them."""
UID = 1234
FRAME_US = 50.1
START_US, START_NS = 1000, 1_000_000
End = tuple[int, int]
"""Cell and port; cell -1 is the Pico."""


class PicoSkin:
    """Runs a Pico and `behind` cells, in three chains at its ports 2 to 4.

    key: the secret of the skin, as the Pico has its keys from it; None: nothing is authenticated.
    """

    def __init__(self, pico: EmulatedPico, behind: int = 3, key: bytes | None = None, percent: float = 0.0) -> None:
        self.pico, self.percent, self.now = pico, percent, 0.0
        self.samples: list[dict[str, int]] = []
        self.ends: list[tuple[float, float]] = []
        """When each frame to the section unit began and ended, us."""
        self.bad = 0
        """Frames out of the Pico that were damaged."""
        self.replies: list[dict[str, int | str]] = []
        self._queue: list[tuple[float, int, Callable[[], None]]] = []
        self._order = 0
        self._due: dict[str, float] = {}
        self._links = _chains(behind)
        self.unit = firmware.SectionUnit()
        self.cells = [firmware.Cell() for _ in range(behind)]
        self.driver = Driver([], spare_cells=behind + 1, spare_groups=1, session_seed=1)
        booted = self.unit.boot(START_NS, 1, session=77, unasked=True, cell_key=key, powered=True, batch_us=1000)
        self._unit_done(booted)
        for at, cell in enumerate(self.cells):
            self._cell_done(at, cell.boot(2000 + at, 7919 * (at + 1), self.us, key=key))
        self._host()

    @property
    def us(self) -> int:
        """Time of the host-built cells."""
        return START_US + int(self.now)

    @property
    def ns(self) -> int:
        """Time of section unit and host."""
        return START_NS + int(self.now * 1000)

    def run_until(self, done: Callable[[], bool], longest_ms: float) -> bool:
        """Let time pass until something holds, and at most so many milliseconds; whether it does."""
        end = self.now + longest_ms * 1000
        while not done():
            if self.now >= end - 0.01:
                return False
            while self._queue and self._queue[0][0] <= self.now:
                heapq.heappop(self._queue)[2]()
            frames = self.pico.run(max(min(end, self._queue[0][0] if self._queue else end), self.now))
            self.now = max(self.now, self.pico.now_us)
            for port, ended, began, frame in frames:
                if port == 1:
                    self.ends.append((began, ended))
                self._hear(port, frame)
        return True

    def run(self, milliseconds: float) -> None:
        """Let time pass."""
        self.run_until(lambda: False, milliseconds)

    @property
    def named(self) -> int:
        """Cells that have an id."""
        return len(self.unit.names)

    @property
    def pico_id(self) -> int:
        """The Pico's; 0: none yet."""
        return int(self.unit.names.get(UID, 0))

    def of_pico(self) -> list[dict[str, int]]:
        """Its samples."""
        return [sample for sample in self.samples if sample["source"] == self.pico_id]

    def _hear(self, port: int, frame: bytes) -> None:
        try:
            name, fields = firmware.unpack(frame)
        except ValueError:
            self.bad += 1
            return
        if port == 1:
            if name in SAMPLE_FRAMES:
                self.samples.append(fields)
            self._unit_done(self.unit.frame(1, frame, self.ns))
        elif (to := self._links.get((-1, port))) is not None:
            self._arrive(to, frame)

    def _at(self, time: float, do: Callable[[], None]) -> None:
        self._order += 1
        heapq.heappush(self._queue, (time, self._order, do))

    def _once(self, name: str, time: float, do: Callable[[], None]) -> None:
        """At that time, unless another time has been named meanwhile."""
        if self._due.get(name) == time:
            return
        self._due[name] = time

        def still_due() -> None:
            if self._due.get(name) == time:
                del self._due[name]
                do()

        self._at(time, still_due)

    def _unit_done(self, output: firmware.SectionUnitOutput) -> None:
        frame = output.frames[0]
        if isinstance(frame, bytes):
            self.pico.send(1, frame, self.percent)
            self._at(self.now + FRAME_US, lambda: self._unit_done(self.unit.sent(1, self.ns)))
        if output.datagram is not None:
            self.driver.handle(output.datagram, self.ns)
        due = (output.timer_ns - START_NS + 999) / 1000
        self._once("unit", due, lambda: self._unit_done(self.unit.timer(self.ns)))

    def _cell_done(self, at: int, output: firmware.CellOutput) -> None:
        cell = self.cells[at]
        for port, frame in enumerate(output.frames, 1):
            if not isinstance(frame, bytes):
                continue
            to = self._links.get((at, port))
            if to is not None and to[0] == -1:
                self.pico.send(to[1], frame, self.percent)
            elif to is not None:
                self._at(self.now + FRAME_US, partial(self._arrive, to, frame))
            self._at(self.now + FRAME_US, partial(self._sent, at, port))
        self._once(f"timer {at}", output.timer_us - START_US, lambda: self._cell_done(at, cell.timer(self.us)))
        if output.sample_us is not None:
            values = [at] * len(firmware.CHANNELS)
            due = output.sample_us - START_US
            self._once(f"sample {at}", due, lambda: self._cell_done(at, cell.sample(values, self.us)))

    def _sent(self, at: int, port: int) -> None:
        self._cell_done(at, self.cells[at].sent(port, self.us))

    def _arrive(self, to: End, frame: bytes) -> None:
        self._cell_done(to[0], self.cells[to[0]].frame(to[1], frame, self.us))

    def _host(self) -> None:
        self.driver.publish(self.ns)
        for _, _, datagram in self.driver.downlink(self.ns):
            self._unit_done(self.unit.datagram(datagram, self.ns))
        self.replies += self.driver.replies()
        self._at(self.now + 1000, self._host)


def _chains(behind: int) -> dict[End, End]:
    links: dict[End, End] = {}
    at = 0
    for port in range(2, 5):
        before = (-1, port)
        for _ in range(behind // 3 + (port - 2 < behind % 3)):
            links[before], links[at, 1] = (at, 1), before
            before = (at, 2)
            at += 1
    return links


def wrong_samples(samples: Sequence[dict[str, int]], expected: dict[str, int]) -> int:
    """How many samples have another value in a channel named."""
    return sum(any(sample[name] != value for name, value in expected.items()) for sample in samples)
