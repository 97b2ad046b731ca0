# SPDX-License-Identifier: Apache-2.0
"""Wrong tags have a budget: guesses soon stop being read, the host is told, and no good port is closed for another."""

import random

import pytest
from small_world import SmallWorld

from robotskin_lab import firmware

KEY = bytes(range(16))
BUDGET, CLOSED_S, TOLD_S = firmware.TAGS_BUDGET, firmware.TAGS_CLOSED_S, firmware.TAGS_TOLD_S
OPERATION = {name: number for name, number, *_ in firmware.OPERATIONS}
FIRST, SECOND, THIRD = range(3)


def row(seed: int, *, ring: bool = False) -> SmallWorld:
    """Section unit, first, second and third cell in a row; with `ring` the third is at the unit's other port, too."""
    links = [((FIRST, 3), (SECOND, 1)), ((SECOND, 3), (THIRD, 1))]
    world = SmallWorld(3, links, [(FIRST, 1), (THIRD, 3)] if ring else [(FIRST, 1)], seed, key=KEY)
    world.run_ms(100)
    assert all(world.cell(index).id for index in range(3))
    return world


def forged(draw: random.Random, kind: str, world: SmallWorld, target: int = firmware.ID_ALL) -> bytes:
    """A frame that would do something, had its tag not been guessed."""
    tick = (world.now + world.ahead_us) // 1000
    fields = {
        "command": {"operation": OPERATION["led"], "counter": draw.getrandbits(16), "target": target, "value_low": 7},
        "joints": {"epoch": tick // 4 & 63, "limb": 1, "joint_1": 5},
        "grant": {"sequence": tick & 0xFFFF, "root": 1, "cell": 1, "target_root": 2},
        "tick": {"sequence": tick + 1 & 0xFFFF, "era": tick >> 16 & 0x3FF, "root": 1, "sender": 16383, "heard": 1,
                 "nonce": 4711 & 0xFF, "gain_threshold": 1},
    }[kind]  # fmt: skip
    return firmware.pack(kind, {**fields, "tag": draw.getrandbits(32)})


def give(world: SmallWorld, index: int, port: int, frame: bytes) -> None:
    world.cell_done(index, world.cell(index).frame(port, frame, world.now))


def refused(world: SmallWorld, index: int) -> int:
    return world.cell(index).counts["tags_refused"]


def told(world: SmallWorld, index: int) -> set[int]:
    """The ports that a cell told to be closed, since the records were cleared."""
    return {
        fields["closed"]
        for _, _, name, fields in world.records
        if name == "topology" and fields["source"] == world.cell(index).id
    } - {0}


@pytest.mark.parametrize("kind", ["command", "joints", "grant", "tick"])
def test_no_more_wrong_tags_are_read_than_the_budget_and_one_a_second(kind: str, seed: int) -> None:
    world, draw = row(seed), random.Random(seed)
    began = world.now
    for _ in range(4 * BUDGET):
        give(world, FIRST, 1, forged(draw, kind, world))
    assert BUDGET <= refused(world, FIRST) <= BUDGET + 1
    assert world.cell(FIRST).parent_port == 0
    while world.now - began < (CLOSED_S + 4) * 1_000_000:
        world.run_ms(draw.uniform(50, 500))
        give(world, FIRST, 1, forged(draw, kind, world))
        assert refused(world, FIRST) <= BUDGET + 1 + (world.now - began) / firmware.TAG_FORGIVEN_US
    assert [node.led for node in world.nodes] == [0] * 3


def test_a_closed_port_opens_again_and_the_host_is_told(seed: int) -> None:
    world, draw = row(seed), random.Random(seed)
    for _ in range(BUDGET + 1):
        give(world, FIRST, 1, forged(draw, "command", world))
    world.records.clear()
    world.run_ms(1000 * (CLOSED_S - 1.1))
    assert world.parent(FIRST) is None
    assert not world.records
    world.run_ms(2500)
    assert world.parent(FIRST) == -1
    assert told(world, FIRST) == {1}
    assert told(world, SECOND) == told(world, THIRD) == set()
    world.command("led", counter=1, value=9)
    world.run_ms(5)
    assert [node.led for node in world.nodes] == [9] * 3
    # Until the budget is back, the next wrong tag closes it again.
    give(world, FIRST, 1, forged(draw, "command", world))
    assert world.cell(FIRST).parent_port == 0


def test_a_cell_with_another_way_goes_on_while_a_port_is_closed(seed: int) -> None:
    world, draw = row(seed, ring=True), random.Random(seed)
    assert world.parent(THIRD) == -1
    for _ in range(BUDGET + 1):
        give(world, THIRD, 3, forged(draw, "joints", world))
    world.records.clear()
    world.run_ms(1500)
    assert world.parent(THIRD) == SECOND
    assert told(world, THIRD) == {3}
    world.command("led", counter=1, value=9)
    world.run_ms(5)
    assert [node.led for node in world.nodes] == [9] * 3


def test_what_a_good_neighbour_passes_on_closes_none_of_its_ports(seed: int) -> None:
    world, draw = row(seed), random.Random(seed)
    target = world.cell(THIRD).id
    for _ in range(3 * BUDGET):
        give(world, FIRST, 1, forged(draw, "command", world, target))
        world.run_ms(1)
    assert refused(world, FIRST) == refused(world, SECOND) == 0
    assert refused(world, THIRD) == BUDGET + 1
    assert [world.parent(index) for index in range(3)] == [-1, FIRST, SECOND]
    world.records.clear()
    world.run_ms(1100)
    assert told(world, THIRD) == {firmware.UNREAD + 1}
    world.command("led", counter=1, value=5)
    world.command("led", counter=2, target=target, value=6)
    world.run_ms(5)
    assert [node.led for node in world.nodes] == [5] * 3
    world.run_ms(1000 * CLOSED_S)
    world.command("led", counter=3, target=target, value=6)
    world.run_ms(5)
    assert world.nodes[THIRD].led == 6


def test_what_a_parent_without_a_name_passes_on_closes_no_port(seed: int) -> None:
    world, draw = row(seed), random.Random(seed)
    named = OPERATION["assign"]

    def withhold(_: tuple[int, int], frame: bytes) -> bytes:
        name, fields = firmware.unpack(frame)
        return bytes(20) if name == "command" and fields["operation"] == named else frame

    world.tamper = withhold  # a device on the cable keeps the second cell without a name
    world.boot(FIRST)
    world.run_ms(60)
    assert world.cell(FIRST).id == 0
    assert world.parent(SECOND) == FIRST
    for _ in range(3 * BUDGET):
        give(world, FIRST, 1, forged(draw, "command", world))
        world.run_ms(1)
    assert refused(world, SECOND) == BUDGET + 1
    assert world.parent(SECOND) == FIRST
    assert world.parent(THIRD) == SECOND
    assert refused(world, THIRD) == 0


def test_ticks_played_again_close_nothing(seed: int) -> None:
    world = row(seed)
    world.heard_frames.clear()
    world.run_ms(20)
    ticks = [frame for end, frame in world.heard_frames if end == (FIRST, 1) and firmware.unpack(frame)[0] == "tick"]
    assert len(ticks) > 4
    world.run_ms(50)
    before = refused(world, FIRST)
    for _ in range(2 * BUDGET):
        give(world, FIRST, 1, ticks[0])
    assert refused(world, FIRST) >= before + 2 * BUDGET
    assert world.parent(FIRST) == -1
    world.records.clear()
    world.run_ms(1100)
    assert told(world, FIRST) == set()
