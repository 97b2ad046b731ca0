# SPDX-License-Identifier: Apache-2.0
"""Laws of planned moves, of one cell: which offer it passes on, and what it does with leave to move."""

from itertools import permutations, product

import pytest
from test_route import Between
from test_sampling import tick

from robotskin_lab import firmware

OWN, OTHER = 1, 2
"""Roots of the own tree and of the one beside it."""
HOLD_US = 2000


class Asked(Between):
    """A cell two hops from its root, with children at ports 2 and 4 and a cell of another tree at port 3."""

    def tick(self, now: int) -> None:
        self.sequence += 1
        self.hear(1, self.told(hops=1, sender=30))

    def told(self, **fields: int) -> bytes:
        return tick(self.sequence, depth_cap=63, gain_threshold=24, **fields)

    def turn(self) -> None:
        self.now += 1000
        self.tick(self.now)
        for port in (2, 4):
            self.hear(port, self.told(sender=38 + port, parent=1, hops=3))
        self.hear(3, self.told(sender=50, hops=2, root=OTHER))

    def named(self) -> None:
        self.command("assign", 0, self.now, index=33, value_low=77, value_high=self.cell.challenge)
        assert self.cell.id == 33

    def ask(self, number: int, **fields: int) -> None:
        """The root wants cells to go to the other tree."""
        wants = {"sequence": self.sequence, "root": OWN, "round": number, "demand_1_root": OTHER, "demand_1_size": 90}
        self.hear(1, firmware.pack("grant", wants | fields))

    def child_says(self, port: int, **fields: int) -> None:
        self.hear(port, firmware.pack("status", {"sender": 38 + port, "size": 1, **fields}))

    def offered(self) -> dict[str, int]:
        """What the last status says."""
        told = [frame for port, frame in self.out if port == 1 and frame[0] >> 4 == 4]
        return firmware.unpack(told[-1])[1]


def test_of_two_offers_the_cheaper_goes_up_then_the_larger_then_that_of_the_lower_id() -> None:
    bench = Asked()
    offers = list(product((1, 3), (4, 6), (61, 62)))
    for first, second in permutations(offers, 2):
        if first[2] == second[2]:
            continue
        bench.ask(5)
        for port, (delta, size, cell) in ((2, first), (4, second)):
            fields = {"candidate": cell, "candidate_size": size, "candidate_delta": delta, "candidate_root": OTHER}
            bench.child_says(port, **fields, candidate_round=5)
        for _ in range(9):  # a status comes every 8 ms at least
            bench.turn()
        told = bench.offered()
        delta, size, cell = min(first, second, key=lambda offer: (offer[0], -offer[1], offer[2]))
        assert (told["candidate_delta"], told["candidate_size"], told["candidate"]) == (delta, size, cell)


def test_an_offer_of_another_round_is_not_passed_on() -> None:
    bench = Asked()
    bench.ask(5)
    bench.child_says(2, candidate=61, candidate_size=4, candidate_root=OTHER, candidate_round=4)
    for _ in range(9):
        bench.turn()
    assert bench.offered()["candidate"] == 0


def test_all_trees_beside_a_subtree_are_told_of_in_turn_and_the_own_one_is_not() -> None:
    bench = Asked()
    bench.child_says(2, foreign_1=3, foreign_2=4, foreign_3=OWN)
    bench.child_says(4, foreign_1=5, foreign_2=4)
    bench.turn()
    told = set()
    for _ in range(9):
        for _ in range(9):
            bench.turn()
        beside = [bench.offered()[f"foreign_{i}"] for i in (1, 2, 3)]
        assert len(set(beside)) == 3
        told |= set(beside)
    assert told == {OTHER, 3, 4, 5}


@pytest.mark.parametrize("grown", ["not at all", "since the round before", "since it offered itself"])
def test_a_cell_moves_with_no_more_than_it_has_offered_in_this_round(grown: str) -> None:
    bench = Asked()
    bench.named()
    bench.child_says(2, size=5)
    for number, size in ((1, 5), (2, 5 if grown == "not at all" else 8)):
        if grown != "since it offered itself":
            bench.child_says(2, size=size)
        bench.ask(number)
        bench.turn()
        bench.child_says(2, size=size)
        bench.turn()
        assert bench.offered()["candidate_size"] == size + 2
    bench.ask(2, cell=33, target_root=OTHER)
    for _ in range(3):
        bench.turn()
    assert bench.cell.root == (OWN if grown == "since it offered itself" else OTHER)


def test_a_move_that_cannot_be_is_given_up_in_time_and_the_tick_that_was_held_back_goes_on() -> None:
    """Those below lose patience otherwise."""
    bench = Asked()
    bench.named()
    bench.ask(1)
    for _ in range(9):
        bench.turn()
    assert bench.offered()["candidate"] == 33
    bench.ask(1, cell=33, target_root=OTHER)
    began, before = bench.now, bench.sequence
    bench.now += 500
    bench.tick(bench.now)
    output = bench.cell.timer(bench.now)
    while output.timer_us <= began + HOLD_US:
        assert bench.cell.sequence == before
        bench.now = output.timer_us
        output = bench.cell.timer(bench.now)
    assert bench.cell.sequence == before + 1
    assert bench.cell.root == OWN


@pytest.mark.parametrize(("number", "blocks"), [(1, 8), (2, 1)])
def test_where_none_offers_itself_all_light_cells_at_the_border_let_go_and_later_one_in_eight_at_a_time(
    number: int, blocks: int
) -> None:
    """Whose turn it is changes every 32 ticks."""
    bench = Asked()
    bench.named()
    let_go = set()
    for _ in range(256):
        bench.ask(number, last_resort=1)
        block = bench.sequence >> 5 & 7
        bench.out.clear()
        bench.turn()
        ticks = [firmware.unpack(frame)[1] for port, frame in bench.out if port == 4 and frame[0] >> 4 == 3]
        if ticks[-1]["draining"]:
            let_go.add(block)
    assert len(let_go) == blocks
