# SPDX-License-Identifier: Apache-2.0
"""Laws of what a section unit makes of the sizes that it hears: which trees are to take cells, and how deep they go."""

import itertools

import pytest
from test_section_unit import Bench, datagram, record

from robotskin_lab import firmware

PEER = {name: number for name, number, _ in firmware.DATAGRAM_KINDS}["peer"]
TICK, GRANT = ({name: number for name, number, _ in firmware.FRAME_TYPES}[name] for name in ("tick", "grant"))


class Trees(Bench):
    """A section unit whose ports hear their trees' sizes, heights and the roots beside them."""

    def __init__(self, told: list[tuple[int, int, int]], **options: object) -> None:
        super().__init__(len(told), **options)
        self.told = told  # by port: size, height and a root beside the tree
        self.offers: dict[int, int] = {}  # by port: the root that another cell of its tree could go to each time
        self.offered = 100
        self.run_ms(90)  # the trees have formed

    def run_ms(self, milliseconds: int) -> None:
        for _ in range(0, milliseconds, 2):
            for port, (size, height, beside) in enumerate(self.told, 1):
                self.attach(port)
                self.hear("status", port, sender=9, size=size, height=height, foreign_1=beside, **self.offer(port))
            self.run_us(2000)  # no port is taken for dead

    def grants(self, port: int) -> list[dict[str, int]]:
        return [firmware.unpack(frame)[1] for at, frame in self.frames if at == port and frame[0] >> 4 == GRANT]

    def offer(self, port: int) -> dict[str, int]:
        if port not in self.offers or not self.grants(port):
            return {}
        self.offered += 1
        told = {"candidate": self.offered, "candidate_size": 1, "candidate_root": self.offers[port]}
        return told | {"candidate_round": self.grants(port)[-1]["round"]}

    def cap_of(self, port: int) -> int:
        """As the newest tick says that went down a port."""
        ticks = [frame for at, frame in self.frames if at == port and frame[0] >> 4 == TICK]
        return firmware.unpack(ticks[-1])[1]["depth_cap"]

    def wants(self, port: int) -> list[list[tuple[int, int]]]:
        """Of each grant frame that went down a port with wants in it: roots and numbers of cells."""
        told = [
            [(fields[f"demand_{w}_root"], fields[f"demand_{w}_size"]) for w in (1, 2, 3)]
            for fields in self.grants(port)
        ]
        return [wants for wants in told if any(root for root, _ in wants)]

    def cap(self) -> int:
        caps = {self.cap_of(port) for port in range(1, len(self.told) + 1)}
        assert len(caps) == 1, "one for all trees that hang together"
        return caps.pop()


def test_where_no_cell_offers_itself_trees_may_grow_deeper_hop_by_hop_but_not_for_ever() -> None:
    bench = Trees([(8, 4, 2), (2, 2, 0)])
    caps = [bench.cap()]
    for _ in range(60):
        bench.run_ms(9)
        caps.append(bench.cap())
    assert sorted(set(caps)) == [5, 6, 7, 8, 9]
    assert caps == sorted(caps)


def test_where_no_cell_ever_offers_itself_those_at_the_border_let_go_in_16_of_256_rounds() -> None:
    """The others only ask: a skin whose loads cannot become even comes to rest, and is told soon if a cell can go."""
    bench = Trees([(8, 1, 2), (2, 1, 0)])
    bench.run_ms(30_000)
    rounds: list[int] = []  # whether cells at the border are to let go
    for before, grant in itertools.pairwise(bench.grants(1)):
        if grant["round"] != before["round"]:
            rounds.append(grant["last_resort"])
    settled = rounds[30:]  # the cap on the depth stays, and what was tried before it was raised counts no more
    bursts = [burst for burst in "".join(map(str, settled)).split("0") if burst]
    assert {len(burst) for burst in bursts[:-1]} == {16}
    assert all(sum(settled[at : at + 256]) == 16 for at in range(len(settled) - 256))
    assert len(settled) > 4 * 256


@pytest.mark.parametrize(("sizes", "cap"), [((5, 5, 5, 3), 5), ((4, 4, 4, 1), 5), ((5, 4, 4, 3), 9)])
def test_where_no_tree_has_more_than_its_share_none_grows_deeper(sizes: tuple[int, ...], cap: int) -> None:
    """The first tree could give a cell to the last, but the fullest cable would carry no fewer."""
    bench = Trees([(size, 4, 4) for size in sizes[:3]] + [(sizes[3], 2, 0)])
    bench.run_ms(600)
    assert {wanted[0][0] for wanted in bench.wants(1)} == {4}
    assert bench.cap() == cap


@pytest.mark.parametrize(
    ("height", "cap", "most"), [(2, 3, 7), (5, 6, 9), (8, 9, 9), (9, 10, 14), (60, 61, 62), (80, 62, 62)]
)
def test_once_cells_come_the_cap_is_the_depth_then_but_hops_that_levelling_added_are_no_new_base(
    height: int, cap: int, most: int
) -> None:
    """Nor does any tree grow deeper than frames live."""
    bench = Trees([(8, 4, 2), (2, 2, 0)])
    bench.run_ms(90)
    bench.told = [(9, height, 2), (2, 2, 0)]
    bench.frames.clear()
    bench.run_ms(30)
    assert bench.cap() == cap
    bench.run_ms(600)
    assert bench.cap() == most


def test_while_cells_come_and_go_the_cap_stays_as_it_was() -> None:
    bench = Trees([(8, 4, 2), (2, 2, 0)])
    bench.run_ms(500)
    assert bench.cap() == 9
    for size in range(10, 40):
        bench.told[0] = (size, 12, 2)
        bench.run_ms(18)
        assert bench.cap() == 9
    bench.run_ms(30)
    assert bench.cap() == 13


@pytest.mark.parametrize("progress", [True, False])
def test_moves_that_are_granted_let_trees_grow_deeper_only_if_they_bring_nothing(progress: bool) -> None:
    bench = Trees([(40, 4, 2), (2, 2, 0)])
    bench.offers[1] = 2
    caps, before = set(), 0
    for _ in range(100):
        bench.run_ms(3)
        granted = len({fields["cell"] for fields in bench.grants(1)} - {0})
        if progress:
            (size, height, beside), (other, *rest) = bench.told
            bench.told = [(size - granted + before, height, beside), (other + granted - before, *rest)]
        before = granted
        caps.add(bench.cap())
    assert before > 8
    assert max(caps) == (5 if progress else 9)


def test_trees_that_hang_together_have_one_cap_whatever_stands_between_their_ports() -> None:
    bench = Trees([(8, 4, 3), (7, 9, 0), (2, 2, 0)])
    assert [bench.cap_of(port) for port in (1, 2, 3)] == [5, 10, 5]
    bench.run_ms(600)
    assert [bench.cap_of(port) for port in (1, 2, 3)] == [9, 10, 9]


def test_trees_that_touch_nothing_keep_a_cap_of_their_own() -> None:
    bench = Trees([(8, 4, 0), (2, 2, 0)])
    bench.run_ms(300)
    assert [bench.cap_of(port) for port in (1, 2)] == [5, 3]


def test_the_largest_surplus_is_wanted_first() -> None:
    bench = Trees([(40, 4, 3), (30, 3, 1), (10, 2, 1)])
    assert bench.wants(1)
    assert all(wants == [(3, 15), (2, 5), (0, 0)] for wants in bench.wants(1))


def test_of_several_surpluses_each_has_its_place_whichever_is_found_first() -> None:
    bench = Trees([(40, 4, 2), (35, 3, 1), (30, 3, 1), (37, 3, 1)])
    assert bench.wants(1)
    assert all(wants == [(3, 5), (2, 3), (4, 2)] for wants in bench.wants(1))


def test_a_neighbour_that_is_to_get_enough_from_others_keeps_no_other_from_being_given_to() -> None:
    bench = Trees([(10, 2, 2), (5, 2, 4), (4, 2, 1), (40, 4, 2)])
    bench.run_ms(200)
    given_to = [{root for root, _ in wants} - {0} for wants in bench.wants(1)]
    assert {3} in given_to


def peer_datagram(bench: Bench, unit: int, sequence: int, size: int, cap: int = 0) -> bytes:
    """What another unit of the group says that hears this one and has 15 trees of that size and cap."""
    session, now = 100 + unit, bench.now & 0xFFFFFFFF
    head = [
        bytes([number, 0]) + named.to_bytes(4, "big") + now.to_bytes(4, "big") + bytes(10)
        for number, named in ((unit, session), (0, 77))
    ]
    tree = size.to_bytes(2, "big") + bytes([2, cap]) + bytes(16)
    trees = [record(tree, port) for port in range(1, 16)]
    return datagram(PEER, sequence, (*head, *trees), unit=unit, session=session, time_ns=bench.now)


def test_of_45_trees_each_wants_to_give_to_the_one_that_is_beside_it() -> None:
    beside = [0x20 | port for port in range(1, 16)]  # the trees of the last unit
    bench = Trees([(1, 0, root) for root in beside])
    bench.told = [(40, 3, root) for root in beside]
    for sequence in range(1, 6):
        for unit in (1, 2):
            bench.say(peer_datagram(bench, unit, sequence, 2))
        bench.run_ms(20)
    assert bench.unit.refused == 0
    wanted = [{root for wants in bench.wants(port) for root, _ in wants} - {0} for port in range(1, 16)]
    assert wanted == [{root} for root in beside]


@pytest.mark.parametrize(("told", "taken"), [(4, 5), (7, 7), (9, 9), (10, 5)])
def test_a_cap_that_another_unit_has_raised_holds_for_the_trees_beside_it_too(told: int, taken: int) -> None:
    """But for more than any may be raised."""
    bench = Trees([(3, 4, 0x11), (3, 2, 0x11)])
    for sequence in range(1, 8):
        bench.say(peer_datagram(bench, 1, sequence, 3, told if sequence > 5 else 0))
        bench.run_ms(20)
    assert bench.cap() == taken
