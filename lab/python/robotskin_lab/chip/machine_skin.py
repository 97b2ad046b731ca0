# SPDX-License-Identifier: Apache-2.0
"""A skin of four cells around a machine: a section unit at its port 1, cells at the others, the host's driver.

The cell on the machine is the only way of the others to the section unit. All that is host-built runs the shipping
firmware in real time, at the pace of the machine's clock.
"""

from __future__ import annotations

import heapq
import select
import time
from collections.abc import Callable
from dataclasses import dataclass, field
from functools import partial
from pathlib import Path
from random import Random

from robotskin.driver import Driver
from robotskin_lab import firmware
from robotskin_lab.chip.errors import ChipError
from robotskin_lab.chip.machine import SLOWER, Machine

COUNTED = 101
"""What stands for the machine's sensors counts round so many (mps2_an385_board.c)."""
UID = 1234
"""Of the machine's cell, unless told otherwise."""
_START_US = 1_000_000


def key_of(seed: int) -> bytes:
    """A skin's key."""
    return Random(seed).randbytes(firmware.CELL_KEY_BYTES)


@dataclass
class Heard:
    """What came out of the machine."""

    frames: dict[str, int] = field(default_factory=dict)
    """By type; all of them with a right checksum."""
    samples: list[dict[str, int]] = field(default_factory=list)
    """Sample frames that came to the section unit, decoded, in order."""
    bytes: int = 0


class MachineSkin:
    """Runs a machine in its skin.

    Args:
        machine: the cell with ports 1 to 4.
        key: of the skin, as the machine has it, or None.
    """

    def __init__(self, machine: Machine, key: bytes | None = None) -> None:
        self.machine = machine
        self.heard = Heard()
        self.unit = firmware.SectionUnit()
        self.cells = [firmware.Cell() for _ in range(firmware.PORTS - 1)]
        """At the machine's ports 2 to 4, each by its port 1."""
        self.replies: list[dict[str, int | str]] = []
        """To the driver's commands."""
        self.driver = Driver([], spare_cells=firmware.PORTS, spare_groups=1, session_seed=1)
        self._receivers = [firmware.Receiver() for _ in machine.lines]
        self._queue: list[tuple[int, int, Callable[[], None]]] = []
        self._order = 0
        self._due: dict[str, int] = {}
        self._began_s = time.monotonic()
        self._unit_done(
            self.unit.boot(self.now_us * 1000, 1, session=77, unasked=True, cell_key=key, powered=True, batch_us=1000)
        )
        for at, cell in enumerate(self.cells):
            self._cell_done(at, cell.boot(2000 + at, 7919 * (at + 1), self.now_us, key=key))
        self._host()

    @property
    def now_us(self) -> int:
        """The time of everything here."""
        return _START_US + int((time.monotonic() - self._began_s) * 1e6 / SLOWER)

    def run_until(self, done: Callable[[], bool], longest_ms: float) -> bool:
        """Let time pass until something holds, and at most so many milliseconds of the cells; whether it does."""
        end_us = self.now_us + int(longest_ms * 1000)
        while not done():
            if self.now_us >= end_us:
                return False
            self._turn()
        return True

    def _turn(self) -> None:
        while self._queue and self._queue[0][0] <= self.now_us:
            heapq.heappop(self._queue)[2]()
        wait_us = self._queue[0][0] - self.now_us if self._queue else 1000
        ready, _, _ = select.select(self.machine.lines, [], [], max(0.0, wait_us * SLOWER / 1e6))
        for line in ready:
            try:
                received = line.recv(4096)
            except ConnectionError:
                received = b""
            self._hear(self.machine.lines.index(line), received)

    def _at(self, time_us: int, do: Callable[[], None]) -> None:
        self._order += 1
        heapq.heappush(self._queue, (time_us, self._order, do))

    def _once(self, name: str, time_us: int, do: Callable[[], None]) -> None:
        """At that time, unless another time has been named meanwhile."""
        if self._due.get(name) == time_us:
            return
        self._due[name] = time_us

        def still_due() -> None:
            if self._due.get(name) == time_us:
                del self._due[name]
                do()

        self._at(time_us, still_due)

    # ---- Lines ----

    def _hear(self, port: int, received: bytes) -> None:
        if not received:
            raise ChipError(f"the machine has ended: {self.machine.said()}")
        self.heard.bytes += len(received)
        for frame in self._receivers[port].feed(received):
            name, fields = firmware.unpack(frame)
            self.heard.frames[name] = self.heard.frames.get(name, 0) + 1
            if port == 0:
                if name == "clock":
                    self.heard.samples.append(fields)
                self._unit_done(self.unit.frame(1, frame, self.now_us * 1000))
            else:
                self._cell_done(port - 1, self.cells[port - 1].frame(1, frame, self.now_us))

    def _send(self, port: int, frame: bytes, sent: Callable[[], None]) -> None:
        try:
            self.machine.lines[port].send(frame)
        except ConnectionError as error:
            raise ChipError(f"the machine has ended: {self.machine.said()}") from error
        self._at(self.now_us + firmware.FRAME_US, sent)

    # ---- Ends ----

    def _unit_done(self, output: firmware.SectionUnitOutput) -> None:
        frame = output.frames[0]
        if frame is not None:
            assert isinstance(frame, bytes)
            self._send(0, frame, lambda: self._unit_done(self.unit.sent(1, self.now_us * 1000)))
        if output.datagram is not None:
            self.driver.handle(output.datagram, self.now_us * 1000)
        due_us = (output.timer_ns + 999) // 1000
        self._once("unit", due_us, lambda: self._unit_done(self.unit.timer(self.now_us * 1000)))

    def _cell_done(self, at: int, output: firmware.CellOutput) -> None:
        cell = self.cells[at]
        frame = output.frames[0]
        if frame is not None:
            assert isinstance(frame, bytes)
            self._send(at + 1, frame, lambda: self._cell_done(at, cell.sent(1, self.now_us)))
        for port in range(2, firmware.PORTS + 1):
            if output.frames[port - 1] is not None:  # no cell is there
                self._at(self.now_us + firmware.FRAME_US, partial(self._sent_into_the_void, at, port))
        self._once(f"timer {at}", output.timer_us, lambda: self._cell_done(at, cell.timer(self.now_us)))
        if output.sample_us is not None:
            values = [0] * len(firmware.CHANNELS)
            self._once(f"sample {at}", output.sample_us, lambda: self._cell_done(at, cell.sample(values, self.now_us)))

    def _sent_into_the_void(self, at: int, port: int) -> None:
        self._cell_done(at, self.cells[at].sent(port, self.now_us))

    def _host(self) -> None:
        """The driver's part, once a millisecond."""
        now_ns = self.now_us * 1000
        self.driver.publish(now_ns)
        for _, _, datagram in self.driver.downlink(now_ns):
            self._unit_done(self.unit.datagram(datagram, now_ns))
        self.replies += self.driver.replies()
        self._at(self.now_us + 1000, self._host)

    # ---- What is known of the machine ----

    def all_named(self) -> bool:
        """Whether the section unit has given an id to each of the four cells."""
        return len(self.unit.names) == 1 + len(self.cells)

    def answered(self, longest_ms: float) -> set[int]:
        """Ping all cells until each has answered, again after a while; those that have, by their keys."""
        end_us = self.now_us + int(longest_ms * 1000)
        self.replies.clear()

        def heard() -> set[int]:
            return {int(reply["key"]) for reply in self.replies}

        while len(heard()) < len(self.unit.names) and self.now_us < end_us:
            self.driver.command("ping")
            self.run_until(lambda: len(heard()) >= len(self.unit.names), 40)
        return heard()

    def machine_id(self, uid: int = UID) -> int:
        """The id of the cell with that serial number, as the section unit has given it; 0: none."""
        return int(self.unit.names.get(uid, 0))

    def wrong_samples(self, uid: int = UID) -> list[dict[str, int]]:
        """Samples of the cell `uid` that are not what the machine's sensors count, or count back."""
        own = self.machine_id(uid)
        wrong = []
        last: int | None = None
        for sample in self.heard.samples:
            if sample["source"] != own:
                continue
            count = sample["proximity"]
            counts = [(count + 7 * at) % COUNTED for at in range(len(firmware.CHANNELS))]
            follows = last is None or 0 < (count - last) % COUNTED < COUNTED // 2
            if [sample[name] for name, *_ in firmware.CHANNELS] != counts or not follows:
                wrong.append(sample)
            last = count
        return wrong


_LONGEST_MS = 100.0
"""For what has to happen."""


def run_machine(elf: Path, seed: int, milliseconds: float) -> dict[str, float]:
    """Boot a program in such a skin with a key, and look at what it does in so long a time of its own.

    Returns how long until all were named (ms), how many cells were, the machine's samples and how many of them were
    wrong, samples that it passed on, all frames that came out of it, and cells that answered a ping.
    """
    key = key_of(seed)
    with Machine(elf, UID, random=seed, key=key) as machine:
        skin = MachineSkin(machine, key)
        began_us = skin.now_us
        skin.run_until(skin.all_named, _LONGEST_MS)
        named_us = skin.now_us
        skin.run_until(lambda: False, milliseconds)
        answered = skin.answered(_LONGEST_MS)
        own = skin.machine_id()
        return {
            "named_ms": (named_us - began_us) / 1000,
            "cells_named": len(skin.unit.names),
            "samples": sum(sample["source"] == own for sample in skin.heard.samples),
            "samples_wrong": len(skin.wrong_samples()),
            "samples_passed_on": sum(sample["source"] != own for sample in skin.heard.samples),
            "frames": sum(skin.heard.frames.values()),
            "cells_answering": len(answered),
        }
