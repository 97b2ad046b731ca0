# SPDX-License-Identifier: Apache-2.0
"""Laws of several section units: one time for the whole group, whatever the clocks say, over links that may fail."""

import hashlib
import heapq
import itertools
import random

import pytest

from robotskin_lab import firmware


def tag(data: bytes) -> bytes:
    return hashlib.blake2s(data, key=bytes(32)).digest()[:16]


class Group:
    """Section units on an Ethernet with `delay_us`; each has a clock that is off by so much and drifts."""

    def __init__(self, offsets_us: list[int], seed: int, *, delay_us: int = 200, keyed: bool = False) -> None:
        self.random = random.Random(seed)
        self.keyed = keyed
        self.delay_us = delay_us
        self.now = 5_000_000_000  # us
        self.offsets = list(offsets_us)
        self.drift = [self.random.uniform(-1e-4, 1e-4) for _ in offsets_us]
        self.units: list[firmware.SectionUnit | None] = [None] * len(offsets_us)
        self.timers = [-1] * len(offsets_us)
        self.parts = [0] * len(offsets_us)  # which units hear each other: those of one part
        self.loss = 0.0
        self.held_up_us = 0  # longer the way from each unit to those after it
        self.queue: list[tuple[int, int, str, int, object]] = []
        self.ticks: list[list[tuple[int, int]]] = [[] for _ in offsets_us]  # (time us, tick number) at port 1
        self.sent: list[tuple[int, bytes]] = []

    def clock_ns(self, unit: int) -> int:
        elapsed = self.now - 5_000_000_000
        return round(1000 * (self.now + self.offsets[unit] + elapsed * self.drift[unit]))

    def at(self, time: int, kind: str, unit: int, what: object = None) -> None:
        heapq.heappush(self.queue, (time, len(self.sent) + self.random.randrange(1 << 40), kind, unit, what))

    def boot(self, unit: int) -> None:
        self.units[unit] = firmware.SectionUnit()
        options = {"tag": tag} if self.keyed else {}
        self.take(
            unit, self.units[unit].boot(self.clock_ns(unit), 1, self.random.randrange(1, 1 << 32), unit=unit, **options)
        )

    def stop(self, unit: int) -> None:
        self.units[unit] = None

    def take(self, unit: int, output: firmware.SectionUnitOutput) -> None:
        if output.frames[0] is not None:
            name, fields = firmware.unpack(output.frames[0])
            if name == "tick":
                self.ticks[unit].append((self.now, fields["era"] * 65536 + fields["sequence"]))
            self.at(self.now + 50, "sent", unit)
        if output.to_peers is not None:
            self.sent.append((unit, output.to_peers))
            for other in range(len(self.units)):
                if other != unit and self.random.random() >= self.loss:
                    way_us = self.delay_us + (self.held_up_us if other > unit else 0)
                    self.at(self.now + way_us, "datagram", other, (self.parts[unit], output.to_peers))
        wait_us = (output.timer_ns - self.clock_ns(unit)) / 1000
        self.timers[unit] = self.now + max(0, round(wait_us)) + (wait_us > 0)
        self.at(self.timers[unit], "timer", unit)

    def run_ms(self, milliseconds: float) -> None:
        end = self.now + int(1000 * milliseconds)
        while self.queue and self.queue[0][0] <= end:
            self.now, _, kind, unit, what = heapq.heappop(self.queue)
            device = self.units[unit]
            if device is None:
                continue
            clock = self.clock_ns(unit)
            if kind == "timer" and self.timers[unit] == self.now:
                self.take(unit, device.timer(clock))
            elif kind == "sent":
                self.take(unit, device.sent(1, clock))
            elif kind == "datagram" and what[0] == self.parts[unit]:
                self.take(unit, device.datagram(what[1], clock))
        self.now = end

    def skew_us(self, since_ms: float) -> float:
        """How far apart the same tick left the units, at most, in the last so many milliseconds."""
        starts = [
            {number: time for time, number in ticks if time > self.now - 1000 * since_ms}
            for unit, ticks in enumerate(self.ticks)
            if self.units[unit] is not None
        ]
        common = set.intersection(*(set(start) for start in starts))
        assert len(common) > 0.8 * since_ms
        return max(max(start[number] for start in starts) - min(start[number] for start in starts) for number in common)


@pytest.mark.parametrize("keyed", [False, True])
def test_units_that_start_together_tick_together_within_100_us(seed: int, keyed: bool) -> None:
    group = Group([0, 40, -9_000_000, 700, 86_400_000_000], seed, keyed=keyed)
    for unit in range(5):
        group.run_ms(0.1)
        group.boot(unit)
    group.run_ms(60)
    assert group.skew_us(40) < 100
    group.run_ms(200)
    assert group.skew_us(150) < 20


def test_a_unit_that_starts_late_takes_the_groups_time_and_moves_none(seed: int) -> None:
    group = Group([-3_600_000_000, 300, 86_400_000_000], seed, keyed=True)
    group.boot(1)
    group.run_ms(100)
    before = group.ticks[1][-1]
    group.boot(0)
    group.run_ms(50)
    group.boot(2)
    group.run_ms(50)
    assert group.skew_us(40) < 100
    after = group.ticks[1][-1]
    assert after[1] - before[1] == pytest.approx((after[0] - before[0]) / 1000, abs=1)


def test_a_unit_that_stops_and_starts_again_is_taken_back(seed: int) -> None:
    group = Group([0, 5000, -5000], seed, keyed=True)
    for unit in range(3):
        group.boot(unit)
    group.run_ms(50)
    for unit in (0, 2, 1):
        group.stop(unit)
        group.run_ms(group.random.randrange(1, 120))
        group.boot(unit)
        group.run_ms(60)
        assert group.skew_us(40) < 100
    numbers = [number for _, number in group.ticks[0]]
    assert numbers == sorted(set(numbers))


def test_parts_that_cannot_hear_each_other_keep_time_and_find_together_again(seed: int) -> None:
    group = Group([0, 5000, -5000, 10], seed)
    for unit in range(4):
        group.boot(unit)
    group.run_ms(50)
    group.parts = [0, 0, 1, 1]
    group.run_ms(400)
    assert group.skew_us(40) < 100 + 2 * 1e-4 * 400_000
    group.parts = [0] * 4
    group.run_ms(100)
    assert group.skew_us(40) < 100


def test_time_only_goes_forward_when_parts_meet_that_never_met(seed: int) -> None:
    group = Group([0, 50_000_000, 50_000_300], seed)
    group.parts = [0, 1, 1]
    for unit in range(3):
        group.boot(unit)
    group.run_ms(30)
    group.parts = [0] * 3
    group.run_ms(200)
    assert group.skew_us(100) < 100
    for ticks in group.ticks:
        steps = [(b[1] - a[1]) % 65536 for a, b in itertools.pairwise(ticks[5:])]
        assert all(0 < step < 32768 for step in steps)


def test_a_way_that_is_held_up_in_one_direction_alone_moves_no_clock(seed: int) -> None:
    group = Group([0, 5000], seed)
    for unit in range(2):
        group.boot(unit)
    group.run_ms(100)
    group.held_up_us = 40_000  # half of that would be taken for the time that clocks are apart
    group.run_ms(600)
    assert group.skew_us(40) < 100 + 2 * 1e-4 * 600_000
    group.held_up_us = 0
    group.run_ms(100)
    assert group.skew_us(40) < 100


def test_loss_on_ethernet_does_no_harm(seed: int) -> None:
    group = Group([0, 5000, -5000], seed)
    group.loss = 0.3
    for unit in range(3):
        group.boot(unit)
    group.run_ms(400)
    assert group.skew_us(200) < 100


def test_datagrams_played_again_change_nothing(seed: int) -> None:
    group = Group([0, 5000], seed, keyed=True)
    for unit in range(2):
        group.boot(unit)
    group.run_ms(100)
    group.stop(1)
    group.run_ms(100)
    group.boot(1)
    group.run_ms(50)
    old = [data for unit, data in group.sent if unit == 1]
    for _ in range(300):
        device = group.units[0]
        assert device is not None
        group.take(0, device.datagram(group.random.choice(old), group.clock_ns(0)))
        group.run_ms(1)
    assert group.skew_us(200) < 100


def test_without_the_key_no_datagram_moves_the_time(seed: int) -> None:
    group = Group([0, 60_000_000], seed, keyed=True)
    group.boot(0)
    group.run_ms(20)
    device = group.units[0]
    assert device is not None
    group.keyed = False
    group.boot(1)
    refused = device.refused
    group.run_ms(100)
    assert device.refused > refused
    steps = [b[1] - a[1] for a, b in itertools.pairwise(group.ticks[0])]
    assert set(steps) == {1}


def test_a_unit_tells_the_others_of_itself_those_it_hears_and_its_trees(seed: int) -> None:
    group = Group([0, 5000, -5000], seed)
    for unit in range(3):
        group.boot(unit)
    group.run_ms(20)
    device, clock = group.units[1], group.clock_ns(1)
    assert device is not None
    group.take(1, device.frame(1, firmware.pack("tick", {"sender": 9, "parent": 1, "heard": 1}), clock))
    group.take(1, device.frame(1, firmware.pack("status", {"sender": 9, "size": 7}), clock))
    group.sent.clear()
    group.run_ms(3.9)
    (told,) = [data for unit, data in group.sent if unit == 1]
    header, record = firmware.DATAGRAM_HEADER_BYTES, firmware.DATAGRAM_RECORD_BYTES
    records = [told[at : at + record] for at in range(header, len(told), record)]
    assert [part[18] >> 4 for part in records] == [0, 0, 0, 1]
    assert [part[0] for part in records[:3]] == [1, 0, 2]
    assert int.from_bytes(records[3][:2], "big") == 7


def test_what_another_unit_says_counts_once(seed: int) -> None:
    group = Group([0, 5000], seed)
    for unit in range(2):
        group.boot(unit)
    group.run_ms(50)
    device = group.units[0]
    assert device is not None
    assert device.refused == 0
    group.take(0, device.datagram([data for unit, data in group.sent if unit == 1][-1], group.clock_ns(0)))
    assert device.refused == 1
