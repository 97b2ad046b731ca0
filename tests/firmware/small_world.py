# SPDX-License-Identifier: Apache-2.0
"""A tiny event loop that runs cells and a section unit of the shipping firmware, for laws about a few dozen cells.

Times are microseconds since the start, the same for all. Links take 50 us a frame and a delay drawn from the seed, and
can be cut, made one-way or lossy. Nothing here knows the protocol.
"""

import heapq
import random
from collections.abc import Callable
from dataclasses import dataclass, field

from robotskin_lab import firmware

Port = tuple[int, int]  # (node, port 1 to n); units are nodes -1, -2, ...


@dataclass
class Node:
    cell: firmware.Cell | None
    timer: int = -1
    sample: int = -1
    last_sample: list[int] = field(default_factory=list)
    flash: bytes | None = None
    led: int = 0
    on: bool = True


class SmallWorld:
    """`links` joins (cell, port) with (cell, port); `roots` lists those at the section unit's ports 1, 2, ..."""

    def __init__(
        self,
        cells: int,
        links: list[tuple[Port, Port]],
        roots: list[Port],
        seed: int,
        *,
        key: bytes | None = None,
        loss: float = 0.0,
        samples: Callable[[int, int], list[int]] = lambda cell, now: [0] * 9,
        flash: dict[int, bytes] | None = None,
        start_us: int = 3_000_000,
        ahead_us: int = 0,
        turns: int = 0,
    ) -> None:
        self.random = random.Random(seed)
        self.now = start_us
        self.ahead_us = ahead_us  # of the unit's clock
        self.turns = turns
        self.loss = loss
        self.samples = samples
        self.key = key
        self.queue: list[tuple[int, int, str, tuple]] = []
        self.order = 0
        self.other: dict[Port, Port] = {}
        for a, b in links:
            self.other[a], self.other[b] = b, a
        for k, root in enumerate(roots):
            self.other[root], self.other[(-1, k + 1)] = (-1, k + 1), root
        self.cut: set[Port] = set()  # sending ends whose frames vanish
        self.sends_until: dict[Port, int] = {}
        self.nodes = [Node(None) for _ in range(cells)]
        self.records: list[tuple[int, int, str, dict]] = []  # (time, port, frame name, fields) that reached the host
        self.sampled: list[tuple[int, int, list[int]]] = []  # (time, cell, values)
        self.watch: Callable[[SmallWorld], None] | None = None  # after each change of a parent, and now and then
        self.parents: list[int] = []
        self.tamper: Callable[[Port, bytes], bytes] | None = None
        self.heard_frames: list[tuple[Port, bytes]] = []
        self.unit = firmware.SectionUnit()
        self.unit_timer = -1
        self.ports = max(1, len(roots))
        self.boot_unit()
        for index in range(cells):
            self.nodes[index].flash = (flash or {}).get(index)
            self.at(self.now + self.random.randrange(1000), "boot", (index,))

    def at(self, time: int, kind: str, what: tuple) -> None:
        self.order += 1
        heapq.heappush(self.queue, (time, self.order, kind, what))

    @property
    def unit_ns(self) -> int:
        return (self.now + self.ahead_us) * 1000

    def ends_sending(self, index: int) -> None:
        """What starts anew knows nothing of a frame that it has begun."""
        self.sends_until = {end: until for end, until in self.sends_until.items() if end[0] != index}

    def boot_unit(self) -> None:
        self.ends_sending(-1)
        self.unit_done(
            self.unit.boot(
                self.unit_ns, self.ports, 4711, unasked=True, cell_key=self.key, batch_us=0, turns=self.turns
            )
        )

    def boot(self, index: int) -> None:
        node = self.nodes[index]
        self.ends_sending(index)
        node.cell = firmware.Cell()
        node.on = True
        node.timer = node.sample = -1
        output = node.cell.boot(1000 + index, self.random.getrandbits(32), self.now, flash=node.flash, key=self.key)
        self.cell_done(index, output)

    def kill(self, index: int) -> None:
        self.nodes[index].on = False

    def cut_link(self, end: Port, *, one_way: bool = False) -> None:
        self.cut.add(end)
        if not one_way:
            self.cut.add(self.other[end])

    def join_link(self, end: Port) -> None:
        self.cut -= {end, self.other[end]}

    def send(self, end: Port, frame: bytes) -> None:
        assert self.sends_until.get(end, 0) <= self.now, f"{end}: a frame is started over another one"
        self.sends_until[end] = self.now + 50
        self.at(self.now + 50, "sent", (end, self.nodes[end[0]].cell if end[0] >= 0 else None))
        if end in self.other and end not in self.cut and self.random.random() >= self.loss:
            if self.tamper is not None:
                frame = self.tamper(end, frame)
            # The wire keeps the order of frames, so the delay stays below the time of a frame.
            self.at(self.now + 50 + self.random.randrange(20), "frame", (self.other[end], frame))

    def cell_done(self, index: int, output: firmware.CellOutput) -> None:
        node = self.nodes[index]
        for port, frame in enumerate(output.frames, 1):
            if frame is not None:
                self.send((index, port), frame)
        if output.timer_us != node.timer:
            node.timer = output.timer_us
            self.at(node.timer, "timer", (index, node.timer))
        if output.sample_us is not None and output.sample_us != node.sample:
            node.sample = output.sample_us
            self.at(node.sample, "sample", (index, node.sample))
        if output.led_rgb is not None:
            node.led = output.led_rgb
        if output.flash is not None:
            node.flash = output.flash

    def unit_done(self, output: firmware.SectionUnitOutput) -> None:
        for port, frame in enumerate(output.frames, 1):
            if frame is not None:
                self.send((-1, port), frame)
        if output.datagram is not None and output.datagram[5] == 1:
            body = output.datagram[firmware.DATAGRAM_HEADER_BYTES :]
            for at in range(0, len(body), firmware.DATAGRAM_RECORD_BYTES):
                content = body[at : at + firmware.CONTENT_BYTES]
                frame = content + firmware.crc16(content).to_bytes(2, "big")
                name, fields = firmware.unpack(frame)
                self.records.append((self.now, body[at + 18] >> 4, name, fields))
        due = (output.timer_ns + 999) // 1000 - self.ahead_us
        if due != self.unit_timer:
            self.unit_timer = due
            self.at(due, "unit timer", (due,))

    def step(self) -> None:
        time, _, kind, what = heapq.heappop(self.queue)
        self.now = max(self.now, time)
        if kind == "unit timer":
            if what[0] == self.unit_timer:
                self.unit_done(self.unit.timer(self.unit_ns))
            return
        if kind == "call":
            what[0]()
            return
        if kind in ("sent", "frame"):
            (index, port), thing = what
            if index < 0:
                now_ns = self.unit_ns
                self.unit_done(self.unit.sent(port, now_ns) if kind == "sent" else self.unit.frame(port, thing, now_ns))
                return
            node = self.nodes[index]
            if not node.on or node.cell is None or (kind == "sent" and node.cell is not thing):
                return
            if kind == "frame":
                self.heard_frames.append(((index, port), thing)) if len(self.heard_frames) < 20000 else None
            output = node.cell.sent(port, self.now) if kind == "sent" else node.cell.frame(port, thing, self.now)
            self.cell_done(index, output)
            return
        index = what[0]
        node = self.nodes[index]
        if kind == "boot":
            self.boot(index)
            return
        if not node.on or node.cell is None:
            return
        if kind == "timer" and node.timer == what[1]:
            self.cell_done(index, node.cell.timer(self.now))
        elif kind == "sample" and node.sample == what[1]:
            node.last_sample = self.samples(index, self.now)
            self.sampled.append((self.now, index, node.last_sample))
            self.cell_done(index, node.cell.sample(node.last_sample, self.now))

    def run_ms(self, milliseconds: float) -> None:
        end = self.now + int(milliseconds * 1000)
        while self.queue and self.queue[0][0] <= end:
            self.step()
            if self.watch is None:
                continue
            parents = [node.cell.parent_port if node.cell is not None else 0 for node in self.nodes]
            if parents != self.parents or self.order % 50 == 0:
                self.parents = parents
                self.watch(self)
        self.now = end

    def cell(self, index: int) -> firmware.Cell:
        cell = self.nodes[index].cell
        assert cell is not None
        return cell

    def parent(self, index: int) -> int | None:
        """The cell that is this cell's parent; -1 for the section unit, None for none."""
        node = self.nodes[index]
        if not node.on or node.cell is None or node.cell.parent_port == 0:
            return None
        return self.other[(index, node.cell.parent_port)][0]

    def distances(self) -> list[int | None]:
        """Hops to the nearest root over links that carry both ways, by breadth-first search."""
        result: list[int | None] = [None] * len(self.nodes)
        wave = [(-1, 0)]
        reached = {-1}
        while wave:
            following = []
            for index, hops in wave:
                for end, far in self.other.items():
                    if end[0] != index or far[0] in reached or {end, far} & self.cut or not self.nodes[far[0]].on:
                        continue
                    reached.add(far[0])
                    result[far[0]] = hops + 1
                    following.append((far[0], hops + 1))
            wave = following
        return result

    def command(
        self, operation: str, *, counter: int, target: int = firmware.ID_ALL, index: int = 0, value: int = 0
    ) -> None:
        """The host sends a command to every cell or one."""
        number = {name: number for name, number, *_ in firmware.OPERATIONS}[operation]
        fields = {
            "target": target, "operation": number, "counter": counter, "index": index, "value_low": value & 0xFFFFFFFF
        }  # fmt: skip
        self.host_sends(firmware.pack("command", fields)[: firmware.CONTENT_BYTES])

    host_sequence = 0

    def host_sends(self, content: bytes) -> None:
        self.host_sequence += 1
        header = (
            firmware.DATAGRAM_MAGIC.to_bytes(4, "big")
            + bytes([firmware.DATAGRAM_VERSION, 4])
            + (0).to_bytes(2, "big")
            + (99).to_bytes(4, "big")
            + self.host_sequence.to_bytes(4, "big")
            + (self.now * 1000).to_bytes(8, "big")
            + (1).to_bytes(2, "big")
            + bytes([0, 0])
            + bytes(8)
        )
        self.unit_done(self.unit.datagram(header + content + bytes(2), self.unit_ns))


def random_skin(cells: int, roots: int, seed: int) -> tuple[list[tuple[Port, Port]], list[Port]]:
    """A connected random graph of cells with four ports each, and free ports for the section unit's cables."""
    draw = random.Random(seed)
    free = {(cell, port) for cell in range(cells) for port in range(1, firmware.PORTS + 1)}

    def take(cell: int) -> Port | None:
        mine = sorted(end for end in free if end[0] == cell)
        if not mine:
            return None
        end = draw.choice(mine)
        free.remove(end)
        return end

    links = []
    for cell in range(1, cells):
        near = [other for other in range(max(0, cell - 8), cell) if any((other, p) in free for p in range(1, 5))]
        a, b = take(draw.choice(near)), take(cell)
        assert a is not None
        assert b is not None
        links.append((a, b))
    for _ in range(cells // 2):
        a_cell = draw.randrange(cells)
        b_cell = min(cells - 1, max(0, a_cell + draw.randrange(-10, 11)))
        if a_cell == b_cell or not any((a_cell, p) in free for p in range(1, 5)):
            continue
        if not any((b_cell, p) in free for p in range(1, 5)):
            continue
        a, b = take(a_cell), take(b_cell)
        assert a is not None
        assert b is not None
        links.append((a, b))
    return links, draw.sample(sorted(free), min(roots, len(free)))
