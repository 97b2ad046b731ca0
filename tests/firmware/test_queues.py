# SPDX-License-Identifier: Apache-2.0
"""Laws of what waits in a cell: what gives way where there is no room, and what is sent again to a new parent."""

import random
from collections import Counter

import pytest
from test_route import Between
from test_sampling import tick

from robotskin_lab import firmware

QUEUE_SLOW = 32


class Crowded(Between):
    """A cell whose lines are free only when the test says so, with a neighbour at port 3 that has a way, too."""

    def __init__(self) -> None:
        self.keeps_busy = False
        super().__init__()

    def take(self, output: firmware.CellOutput, now: int) -> None:
        if not self.keeps_busy:
            super().take(output, now)
            return
        self.out += [(port, frame) for port, frame in enumerate(output.frames, 1) if frame is not None]

    def turn(self) -> None:
        super().turn()
        self.beside()

    def beside(self, later: int = 0) -> None:
        self.hear(3, tick(self.sequence + later, sender=50, hops=5, sender_port=2))

    def free(self, port: int) -> None:
        """All that waits for a port goes out, a frame each 50 us."""
        self.keeps_busy = True
        for _ in range(200):
            self.now += 50
            self.take(self.cell.sent(port, self.now), self.now)


@pytest.mark.parametrize("bit", [45, 100, 159])
def test_a_damaged_sample_of_a_child_goes_no_further(bit: int) -> None:
    bench = Crowded()
    frame = bytearray(firmware.pack("clock", {"source": 9, "ttl": 63}))
    for damaged in (0, 1):
        bench.now += 100
        bench.out.clear()
        bench.hear(2, bytes(frame))
        passed_on = [port for port, sent in bench.out if sent[0] >> 4 == frame[0] >> 4]
        assert passed_on == ([] if damaged else [1])
        assert bench.cell.counts["frames_damaged"] == damaged
        frame[bit // 8] ^= 0x80 >> bit % 8


@pytest.mark.parametrize(("kind", "changing"), [("topology", "revision"), ("join", "challenge")])
def test_a_newer_report_of_a_cell_takes_the_place_of_its_last_one_where_there_is_no_room(
    kind: str, changing: str, seed: int
) -> None:
    draw, bench = random.Random(seed), Crowded()
    for _ in range(5):  # the ring goes round
        bench.hear(2, firmware.pack(kind, {"uid": 9, "ttl": 9}))
    bench.keeps_busy = True
    cells = {0x51234560 + k: {"uid": 0x51234560 + k, "ttl": 9, changing: 1} for k in range(QUEUE_SLOW + 1)}
    if kind == "topology":
        for source, fields in enumerate(cells.values(), 300):
            fields["source"] = source
    bench.out.clear()
    dropped = bench.cell.counts["repeats_dropped"]
    for fields in cells.values():
        bench.hear(2, firmware.pack(kind, fields))
    for uid in draw.sample(sorted(cells)[1:], 12):  # the first is on its way
        cells[uid][changing] = 2
        bench.hear(2, firmware.pack(kind, cells[uid]))
    assert bench.cell.counts["repeats_dropped"] == dropped
    bench.hear(2, firmware.pack(kind, {"uid": 0x61234560, "ttl": 9}))
    assert bench.cell.counts["repeats_dropped"] == dropped + 1
    bench.free(1)
    told = [firmware.unpack(frame) for port, frame in bench.out if port == 1]
    heard = [(fields["uid"], fields[changing]) for name, fields in told if name == kind and fields["uid"] in cells]
    assert sorted(heard) == [(uid, fields[changing]) for uid, fields in sorted(cells.items())]


def sent_again(first: int, sent: int, waiting: int) -> tuple[list[int], list[int]]:
    """Sources of the samples that go to a new parent: of those that the last one got before it fell silent, the rest.

    Cells have consecutive ids; all their samples are of the moment before.
    """
    bench = Crowded()
    bench.out.clear()

    def sample(source: int, **more: int) -> bytes:
        told = {"source": source, "ttl": 9, "sample_tick": bench.sequence % 16, "sample_phase": 10}
        return firmware.pack("clock", told | more)

    bench.now += 200
    for source in range(first, first + sent):
        bench.hear(2, sample(source))
    bench.keeps_busy = True
    for source in range(first + sent, first + sent + waiting):
        bench.hear(2, sample(source, retransmitted=1))
    for later in range(1, 7):
        bench.now += 1000
        bench.take(bench.cell.timer(bench.now), bench.now)
        bench.beside(later)
    assert bench.cell.parent_port == 3
    bench.free(3)
    told = [firmware.unpack(frame) for port, frame in bench.out if port == 3]
    sources = [fields["source"] for name, fields in told if name == "clock"]
    assert all(fields["retransmitted"] for name, fields in told if name == "clock")
    assert max(Counter(sources).values(), default=1) == 1
    return [at for at in sources if at < first + sent], [at for at in sources if at >= first + sent]


def test_what_went_to_a_parent_that_fell_silent_goes_to_the_next_one(seed: int) -> None:
    assert sent_again(100 * seed, 8, 0) == (list(range(100 * seed, 100 * seed + 8)), [])


def test_of_much_that_went_to_a_silent_parent_every_other_sample_goes_to_the_next_one(seed: int) -> None:
    """Of those sent first and last alike."""
    again, _ = sent_again(100 * seed, 40, 0)
    for tenth in range(100 * seed, 100 * seed + 40, 10):
        assert 2 <= len([source for source in again if tenth <= source < tenth + 10]) <= 8


def test_what_waits_already_leaves_its_room_to_what_is_sent_again(seed: int) -> None:
    again, rest = sent_again(100 * seed, 40, 30)
    assert rest[-29:] == list(range(100 * seed + 41, 100 * seed + 70))
    assert len(again) >= 8


def test_no_frame_begins_on_a_line_that_has_one(seed: int) -> None:
    """Whatever comes meanwhile: sums and events of a child, its ticks that ask for an answer, those of the parent."""
    draw, bench = random.Random(seed), Crowded()
    bench.keeps_busy = True
    since: dict[int, int] = {}
    due = bench.now + 1000

    def check(output: firmware.CellOutput) -> None:
        for port, frame in enumerate(output.frames, 1):
            if frame is not None:
                assert port not in since
                since[port] = bench.now

    for number in range(2000):
        bench.now += draw.randrange(10, 80)
        for port in [at for at in since if draw.random() < 0.1 or bench.now - since[at] > 2000]:
            del since[port]
            check(bench.cell.sent(port, bench.now))
        if bench.now >= due:
            due += 1000
            bench.sequence += 1
            check(bench.cell.frame(1, tick(bench.sequence), bench.now))
        told = {"sender": 40, "parent": 1, "hops": 2, "sender_port": 1, "ack": draw.randrange(128)}
        over = {"epoch": (bench.sequence // firmware.EPOCH_TICKS - 1) % 64, "serial": number % 32, "cells": 1}
        kind = draw.choice(["torque", "event", "tick", "tick"])
        frame = {
            "torque": firmware.pack("torque", over),
            "event": firmware.pack("event", {"source": 40, "sequence": number % 256, "ttl": 9}),
            "tick": tick(bench.sequence, **told),
        }[kind]
        check(bench.cell.frame(2, frame, bench.now))
    assert bench.cell.parent_port == 1
