# SPDX-License-Identifier: Apache-2.0
"""Laws of one cell between neighbours that are played by hand: which it follows, which it hears, what it passes on."""

from collections.abc import Mapping

import pytest
from small_world import SmallWorld
from test_network import at_two_ports, run_on_ticks
from test_sampling import Feeder, tick

from robotskin_lab import firmware

NONE: frozenset[int] = frozenset()


def hear_two(
    cell: firmware.Cell,
    now: int,
    first: int,
    ticks: int,
    hops: Mapping[int, int],
    *,
    lossy: frozenset[int] = NONE,
    still: frozenset[int] = NONE,
    mute: frozenset[int] = NONE,
) -> int:
    """Ticks of neighbours at port 1 each millisecond, and 0.3 ms later at port 2, that are so many hops away.

    Of what comes in at the ports in `lossy`, three frames of four are damaged; those in `still` say the tick of before,
    those in `mute` nothing.
    """
    told = {"nonce": 9, "heard": 1, "depth_cap": 63, "gain_threshold": 24, "root": 0x11}
    moments = at_two_ports(cell, now, first, ticks)
    for sequence, port, now in moments:
        said = first - 1 if port in still else sequence
        fields = {"sender": 4 + port, "sender_port": port, "hops": hops[port], "sequence": said}
        frame = bytearray(firmware.pack("tick", {**told, **fields}))
        if port in lossy and sequence % 4:
            frame[7] ^= 1
        if port not in mute:
            cell.frame(port, bytes(frame), now)
    return now


def cell_between(hops: Mapping[int, int]) -> tuple[firmware.Cell, int]:
    cell = firmware.Cell()
    cell.boot(7, 1, 3_000_000)
    now = run_on_ticks(cell, 3_000_000, 88, 12, hops=hops[1], root=0x11)
    return cell, hear_two(cell, now, 100, 12, hops)


@pytest.mark.parametrize("near", [1, 2])
def test_a_cell_comes_back_to_the_nearer_neighbour_once_its_line_spoils_no_frames(near: int) -> None:
    """Whichever of the two says first which tick it is."""
    hops = {near: 4, 3 - near: 5}
    cell, now = cell_between(hops)
    assert cell.parent_port == near
    now = hear_two(cell, now, 112, 8, hops, lossy=frozenset({near}))
    assert cell.parent_port == 3 - near
    hear_two(cell, now, 120, 20, hops)
    assert cell.parent_port == near


def test_a_cell_whose_parent_stands_still_soon_follows_one_that_goes_on_though_its_way_is_longer() -> None:
    hops = {1: 4, 2: 5}
    cell, now = cell_between(hops)
    now = hear_two(cell, now, 112, 3, hops, still=frozenset({1}))
    assert cell.parent_port == 1
    hear_two(cell, now, 115, 4, hops, still=frozenset({2}))  # neither goes on
    assert cell.parent_port == 1
    cell, now = cell_between(hops)
    hear_two(cell, now, 112, 7, hops, still=frozenset({1}))
    assert cell.parent_port == 2


def test_a_link_that_has_fallen_so_often_that_it_is_counted_no_further_is_kept_out_all_the_same() -> None:
    hops = {1: 3, 2: 3}
    cell, now, sequence = firmware.Cell(), 3_000_000, 100

    def hear(ticks: int, *mute: int) -> None:
        nonlocal now, sequence
        now = hear_two(cell, now, sequence, ticks, hops, mute=frozenset(mute))
        sequence += ticks

    cell.boot(7, 1, now)
    for _ in range(20):
        hear(8, 2)
        assert cell.neighbours[0]["up"], "there is no other way"
        hear(30, 1, 2)
        assert not cell.neighbours[0]["up"]
    hear(8, 1)
    assert cell.parent_port == 2
    for _ in range(50):
        hear(1)
        assert not cell.neighbours[0]["up"]


def test_only_frames_without_a_silence_between_them_make_a_link() -> None:
    told = {"sender": 8, "nonce": 4, "heard": 1, "depth_cap": 63, "gain_threshold": 24, "hops": 9, "root": 0x11}
    for silence in range(4, 24):
        cell = firmware.Cell()
        cell.boot(7, 1, 3_000_000)
        now = run_on_ticks(cell, 3_000_000, 100, 12, hops=2, root=0x11)
        for wait, up in ((1, False), (1, False), (silence, False), (1, False), (1, True)):
            now = run_on_ticks(cell, now, cell.sequence + 1, wait, hops=2, root=0x11)
            cell.frame(2, firmware.pack("tick", {**told, "sequence": cell.sequence}), now)
            assert cell.neighbours[1]["up"] == up, silence


class Between(Feeder):
    """A cell with a root at port 1 and a child at port 2; all that it sends, with the port."""

    def __init__(self) -> None:
        super().__init__()
        self.now = 5_000_000
        self.number = 0  # of the child's next event
        self.out: list[tuple[int, bytes]] = []
        self.take(self.cell.boot(77, 1, self.now), self.now)
        for _ in range(12):
            self.turn()

    def take(self, output: firmware.CellOutput, now: int) -> None:
        pending = [(port, frame) for port, frame in enumerate(output.frames, 1) if frame is not None]
        while pending:
            self.out += pending[:1]
            port, _ = pending.pop(0)
            following = self.cell.sent(port, now)
            pending += [(p, f) for p, f in enumerate(following.frames, 1) if f is not None]

    def hear(self, port: int, frame: bytes) -> None:
        self.take(self.cell.frame(port, frame, self.now), self.now)

    def turn(self) -> None:
        """A millisecond, with a tick of the root and then one of the child."""
        self.now += 1000
        self.tick(self.now)
        self.hear(2, tick(self.sequence, sender=40, parent=1, hops=2, ack=self.number, sender_port=1))


def test_a_child_is_told_which_of_its_events_have_come(seed: int) -> None:
    bench = Between()
    for count in [seed % 3, 1, 4, 0, 2, 3]:
        for _ in range(count):
            bench.hear(2, firmware.pack("event", {"source": 40, "sequence": bench.number, "ttl": 9}))
            bench.number += 1
        bench.turn()
        bench.out.clear()
        bench.now += 1000
        bench.tick(bench.now)
        (told,) = [firmware.unpack(frame)[1] for port, frame in bench.out if port == 2 and frame[0] >> 4 == 3]
        assert told["ack"] == bench.number


@pytest.mark.parametrize("kind", ["clock", "event", "topology", "reply", "join"])
def test_what_has_no_hop_left_goes_no_further(kind: str) -> None:
    bench = Between()
    for ttl, passed_on in ((1, 1), (0, 0), (1, 1)):
        bench.out.clear()
        exhausted = bench.cell.counts["hops_exhausted"]
        bench.hear(2, firmware.pack(kind, {"ttl": ttl}))
        told = [firmware.unpack(frame) for port, frame in bench.out if port == 1]
        assert [fields["ttl"] for name, fields in told if name == kind] == [0] * passed_on
        assert bench.cell.counts["hops_exhausted"] - exhausted == 1 - passed_on


@pytest.mark.parametrize("kind", ["event", "topology", "reply", "join"])
def test_what_comes_over_a_line_of_which_little_has_been_heard_is_passed_on(kind: str) -> None:
    bench = Between()
    bench.out.clear()
    bench.hear(3, firmware.pack(kind, {"ttl": 9}))
    assert [firmware.unpack(frame)[0] for port, frame in bench.out if port == 1] == [kind]


def test_both_ends_of_a_link_that_is_mended_soon_report_it(seed: int) -> None:
    """Though no cell changes its parent for it."""
    world = SmallWorld(3, [((0, 2), (1, 1)), ((0, 3), (2, 1)), ((1, 2), (2, 2))], [(0, 1)], seed)
    world.run_ms(100)
    ids = [world.cell(index).id for index in range(3)]
    world.cut_link((1, 2))
    world.run_ms(100)
    world.join_link((1, 2))
    world.records.clear()
    world.run_ms(50)
    told = {fields["source"]: fields["neighbour_2"] for _, _, name, fields in world.records if name == "topology"}
    assert told[ids[1]] == ids[2]
    assert told[ids[2]] == ids[1]
