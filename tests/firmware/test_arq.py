# SPDX-License-Identifier: Apache-2.0
"""Laws of the ARQ: no event is lost on any single failure, none is kept for ever, and every cell's come in order."""

from collections import defaultdict

import pytest
from small_world import SmallWorld, random_skin
from test_sampling import Feeder, tick

from robotskin_lab import firmware


class Counting:
    """Every sample of a cell is another: proximity counts, so that each one is an event."""

    def __init__(self) -> None:
        self.count: dict[int, int] = defaultdict(int)

    def __call__(self, cell: int, now: int) -> list[int]:
        self.count[cell] += 16
        return [self.count[cell] % 65536] + [0] * 8


def event_skin(cells: int, seed: int, rate_hz: int = 250, **options: object) -> SmallWorld:
    links, roots = random_skin(cells, 2, seed)
    world = SmallWorld(cells, links, roots, seed, samples=Counting(), **options)
    world.run_ms(60)
    world.command("event_rate", counter=1, value=rate_hz)
    world.command("mode", counter=2, value=1)
    world.run_ms(60)
    world.records.clear()
    return world


def missing(world: SmallWorld, cells: set[int]) -> dict[int, list[int]]:
    """Of each cell the sequence numbers between its first and its last event at the host that never came."""
    cell_of = {world.cell(index).id: index for index in range(len(world.nodes))}
    heard: dict[int, list[int]] = defaultdict(list)
    for _, _, name, fields in world.records:
        if name == "event":
            heard[cell_of[fields["source"]]].append(fields["sequence"])
    lost = {}
    for index in cells:
        unwrapped = []
        for sequence in heard[index]:
            last = unwrapped[-1] if unwrapped else sequence
            unwrapped.append(last + (sequence - last + 128) % 256 - 128)
        assert len(unwrapped) > 10, f"cell {index} fell silent"
        gaps = sorted(set(range(min(unwrapped), max(unwrapped))) - set(unwrapped))
        if gaps:
            lost[index] = gaps
    return lost


def reachable(world: SmallWorld) -> set[int]:
    return {index for index, hops in enumerate(world.distances()) if hops is not None}


@pytest.mark.parametrize("trial", range(3))
@pytest.mark.parametrize("fault", ["link", "one-way up", "one-way down", "cell", "flap"])
def test_no_event_is_lost_on_a_single_failure(fault: str, trial: int, seed: int) -> None:
    world = event_skin(24, 100 * seed + trial)
    tree = [index for index in range(24) if world.parent(index) is not None and world.parent(index) >= 0]
    world.run_ms(10 + world.random.random())
    victim = world.random.choice(tree)
    up = (victim, world.cell(victim).parent_port)
    dead: set[int] = set()
    match fault:
        case "link":
            world.cut_link(up)
        case "one-way up":
            world.cut_link(up, one_way=True)
        case "one-way down":
            world.cut_link(world.other[up], one_way=True)
        case "cell":
            dead = {world.parent(victim)}
            world.kill(*dead)
        case "flap":
            world.cut_link(up)
            world.run_ms(2.5)
            world.join_link(up)
    alive = reachable(world) - dead
    world.run_ms(60)
    assert missing(world, alive) == {}


def test_every_lost_frame_is_sent_again(seed: int) -> None:
    world = event_skin(20, seed, rate_hz=500)
    world.loss = 2e-3
    world.run_ms(300)
    world.loss = 0.0
    world.run_ms(20)
    assert missing(world, set(range(20))) == {}
    retransmitted = sum(fields["retransmitted"] for _, _, name, fields in world.records if name == "event")
    assert retransmitted > 0


def test_what_is_sent_again_says_so_and_comes_in_order(seed: int) -> None:
    world = event_skin(16, seed, loss=0.0)
    world.loss = 1e-2
    world.run_ms(300)
    newest: dict[int, int] = {}
    for _, _, name, fields in world.records:
        if name != "event":
            continue
        ahead = (fields["sequence"] - newest.get(fields["source"], fields["sequence"] - 1) + 128) % 256 - 128
        if ahead <= 0:
            assert fields["retransmitted"] == 1
        else:
            newest[fields["source"]] = fields["sequence"]


def test_nothing_is_kept_longer_than_its_time_can_be_told(seed: int) -> None:
    world = event_skin(12, seed)
    ages = []
    world.loss = 0.02
    for _ in range(6):
        victim = world.random.randrange(12)
        ends = [end for end in world.other if end[0] == victim]
        for end in ends:
            world.cut_link(end)
        world.run_ms(world.random.uniform(2, 30))
        for end in ends:
            world.join_link(end)
        world.run_ms(20)
    cell_of = {world.cell(index).id: index for index in range(12)}
    taken = {(index, values[0]): time for time, index, values in world.sampled}
    for arrival, _, name, fields in world.records:
        if name == "event":
            ages.append(arrival - taken[cell_of[fields["source"]], fields["proximity"]])
    assert len(ages) > 300
    assert max(ages) < firmware.ARQ_KEEP_US + 2500  # and the way to the section unit
    assert max(ages) < 16 * firmware.TICK_US


def test_a_quiet_skin_repeats_nothing(seed: int) -> None:
    world = event_skin(16, seed)
    world.run_ms(200)
    assert sum(fields["retransmitted"] for _, _, name, fields in world.records if name == "event") == 0


def longest_silence_us(world: SmallWorld, cells: set[int], since_us: int) -> int:
    """Between two samples of one cell that the host had not got before, or from the last one until now."""
    cell_of = {world.cell(index).id: index for index in range(len(world.nodes))}
    heard: dict[int, int] = {}
    known: set[tuple[int, int]] = set()
    longest = 0
    for time, _, name, fields in world.records:
        if name != "clock" or (fields["source"], fields["sequence"]) in known:
            continue
        known.add((fields["source"], fields["sequence"]))
        index = cell_of[fields["source"]]
        if index in cells and time >= since_us and index in heard:
            longest = max(longest, time - heard[index])
        heard[index] = time
    return max([longest, *(world.now - max(heard.get(index, 0), since_us) for index in cells)])


@pytest.mark.parametrize("trial", range(3))
@pytest.mark.parametrize("fault", ["link", "one-way up", "one-way down", "cell"])
def test_no_single_failure_silences_a_cell_for_three_samples(fault: str, trial: int, seed: int) -> None:
    links, roots = random_skin(24, 2, 100 * seed + trial)
    world = SmallWorld(24, links, roots, 100 * seed + trial)
    world.run_ms(100 + 4 * world.random.random())
    tree = [index for index in range(24) if world.parent(index) is not None and world.parent(index) >= 0]
    victim = world.random.choice(tree)
    up = (victim, world.cell(victim).parent_port)
    dead = {world.parent(victim)} if fault == "cell" else set()
    world.records.clear()
    begun_us = world.now
    world.run_ms(20)
    if fault == "cell":
        world.kill(*dead)
    else:
        world.cut_link(world.other[up] if fault == "one-way down" else up, one_way=fault != "link")
    alive = reachable(world) - dead
    world.run_ms(60)
    assert longest_silence_us(world, alive, begun_us) < 12_500
    again = [fields for _, _, name, fields in world.records if name == "clock" and fields["retransmitted"]]
    assert len(again) <= len(alive)  # at most the last one of each


class Sender(Feeder):
    """A cell that sends events to a root at port 1, whose line is free when the test says so."""

    def __init__(self) -> None:
        super().__init__()
        self.now = 5_000_000
        self.take(self.cell.boot(77, 1, self.now), self.now)
        for _ in range(12):
            self.now += 1000
            self.tick(self.now)
            self.take(self.cell.frame(2, tick(self.sequence, sender=40, parent=1, hops=2), self.now), self.now)
        self.sent.clear()

    def event(self, sequence: int, *, free: bool = True, **fields: int) -> None:
        told = {"source": 40, "ttl": 9, "sequence": sequence, "sample_tick": self.sequence % 16, **fields}
        output = self.cell.frame(2, firmware.pack("event", told), self.now)
        if free:
            self.take(output, self.now)
        else:
            self.sent += [frame for frame in output.frames[:1] if frame is not None]

    def events(self) -> list[int]:
        told = map(firmware.unpack, self.sent)
        return [fields["sequence"] for name, fields in told if name == "event"]


def test_an_event_that_waits_already_is_not_sent_twice() -> None:
    """Whatever was sent before it: the ring that holds it goes round."""
    for before in (0, 5, 60, 126):
        sender = Sender()
        for sequence in range(before):
            sender.event(sequence)
        for _ in range(firmware.ARQ_KEEP_US // 1000 + 8):
            sender.now += 1000
            sender.tick(sender.now)
            sender.take(sender.cell.timer(sender.now), sender.now)
        sender.sent.clear()
        sender.event(200, free=False)
        for sequence in (201, 202, 203):
            sender.event(sequence, free=False)
        for sequence in (201, 203):
            sender.event(sequence, free=False, retransmitted=1)
        sender.now += 100
        sender.take(sender.cell.sent(1, sender.now), sender.now)
        assert sender.events() == [200, 201, 202, 203], before


@pytest.mark.parametrize("late", range(4))
def test_any_of_the_last_four_ticks_may_be_the_one_up_to_which_all_was_heard(late: int) -> None:
    """The parent's answer takes its time, and what comes after that is sent again."""
    sender, told = Sender(), []
    for sequence in range(10):
        sender.event(sequence)
        sender.sent.clear()
        sender.now += 1000
        sender.tick(sender.now)
        (number,) = [fields["ack"] for name, fields in map(firmware.unpack, sender.sent) if name == "tick"]
        told.append(number)
    sender.sent.clear()
    answer = tick(sender.sequence + 1, ack=128 + told[-1 - late])
    sender.take(sender.cell.frame(1, answer, sender.now + 500), sender.now + 500)
    assert sender.events() == list(range(10 - late, 10))
