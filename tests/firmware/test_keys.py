# SPDX-License-Identifier: Apache-2.0
"""What an attacker on the wire can make a cell do: nothing, whatever was forged, guessed or recorded before.

Every attack is shown to have teeth: with the key, or at the time that it was made for, the same frame does pass.
"""

import random
from collections.abc import Iterable

import pytest
from small_world import SmallWorld, random_skin

from robotskin_lab import firmware

KEY = bytes(range(16))
CELLS = 8
TURN_US = 2**26 * 1000
GUESSES = 20_000
OPERATION = {name: number for name, number, *_ in firmware.OPERATIONS}
Frame = tuple[int, bytes]  # port, content and checksum


def skin(seed: int, **options: int) -> SmallWorld:
    links, roots = random_skin(CELLS, 2, seed)
    world = SmallWorld(CELLS, links, roots, seed, key=KEY, **options)
    world.run_ms(60)
    assert all(world.cell(index).id for index in range(CELLS))
    return world


def order(world: SmallWorld, victim: int) -> list[Frame]:
    """What the victim heard of three commands: to it, to all, to it."""
    world.heard_frames.clear()
    for counter, target in ((1, world.cell(victim).id), (2, firmware.ID_ALL), (3, world.cell(victim).id)):
        world.command("led", counter=counter, target=target, value=counter)
        world.run_ms(3)
    heard = [(port, frame) for (index, port), frame in world.heard_frames if index == victim]
    return [(port, frame) for port, frame in heard if firmware.unpack(frame)[0] == "command"]


def accepted(world: SmallWorld, victim: int, frames: Iterable[bytes]) -> int:
    """How many of the frames change the LED of the victim, which gets them at the port of its parent."""
    count = 0
    for frame in frames:
        world.nodes[victim].led = -1
        world.cell_done(victim, world.cell(victim).frame(world.cell(victim).parent_port, frame, world.now))
        count += world.nodes[victim].led != -1
    return count


def signed(world: SmallWorld, key: bytes, target: int, counter: int = 9) -> bytes:
    """A command under a key, for now."""
    fields = {"operation": OPERATION["led"], "counter": counter, "target": target, "value_low": 0xABCDEF}
    content = firmware.pack("command", fields)[:14]
    second = (world.now + world.ahead_us) // 1000 % 2**26 >> 10
    tag = firmware.chaskey(key, content + second.to_bytes(2, "big"))[:4]
    return firmware.pack("command", fields | {"tag": int.from_bytes(tag, "big")})


def of_turn(key: bytes, turn: int) -> bytes:
    return firmware.chaskey(key, b"\x03" + turn.to_bytes(4, "big"))


def power_cycle(world: SmallWorld, victim: int) -> None:
    world.boot(victim)
    world.run_ms(40)
    assert world.cell(victim).id


def test_keys_of_a_cell_tell_none_of_another(seed: int) -> None:
    uids = random.Random(seed).sample(range(1, 2**32), 50)
    made = [firmware.cell_keys(KEY, uid) for uid in uids]
    assert len({keys[:16] for keys in made}) == 1
    assert len({keys[16:] for keys in made} | {made[0][:16], KEY}) == 52
    assert firmware.cell_keys(bytes(16), uids[0]) != made[0]


def test_one_opened_cell_commands_no_other(seed: int) -> None:
    world = skin(seed, turns=seed + 5)
    opened, victim = 2, 5
    keys = firmware.cell_keys(KEY, world.cell(opened).uid)
    known = [key for base in (keys[:16], keys[16:]) for key in (base, of_turn(base, world.turns))]
    target = world.cell(victim).id
    assert accepted(world, victim, [signed(world, key, target) for key in known]) == 0
    own = of_turn(firmware.cell_keys(KEY, world.cell(victim).uid)[16:], world.turns)
    assert accepted(world, victim, [signed(world, own, firmware.ID_ALL)]) == 0
    assert accepted(world, victim, [signed(world, own, target)]) == 1
    # What is for all, the opened cell can forge; the page says so.
    assert accepted(world, victim, [signed(world, of_turn(keys[:16], world.turns), firmware.ID_ALL, 10)]) == 1


def test_guessed_commands_do_nothing(seed: int) -> None:
    world, victim = skin(seed), 4
    draw = random.Random(seed)
    forged = (
        firmware.pack(
            "command",
            {
                "operation": OPERATION["led"],
                "counter": 1 + draw.randrange(30000),
                "target": draw.choice((world.cell(victim).id, firmware.ID_ALL)),
                "value_low": 7,
                "tag": draw.getrandbits(32),
            },
        )
        for _ in range(GUESSES)
    )
    assert accepted(world, victim, forged) == 0
    world.run_ms(1000 * (firmware.TAGS_CLOSED_S + 1))  # the guesses have closed its ports
    assert len(order(world, victim)) == 3
    assert world.nodes[victim].led == 3  # it obeys again


def test_recorded_commands_do_nothing_in_the_same_run(seed: int) -> None:
    world, victim = skin(seed), 3
    heard = [frame for _, frame in order(world, victim)]
    assert len(heard) == 3
    assert accepted(world, victim, heard) == 0
    power_cycle(world, victim)
    assert accepted(world, victim, heard) == 0
    world.boot_unit()
    for index in range(CELLS):
        world.boot(index)
    world.run_ms(80)
    assert world.cell(victim).id
    world.run_ms(1600)  # the unit knows no counter of before; what it tagged then is of another second
    assert accepted(world, victim, heard) == 0


@pytest.mark.parametrize(
    ("options", "passes"),
    [({}, True), ({"ahead_us": TURN_US}, False), ({"ahead_us": 5 * TURN_US}, False), ({"turns": 1}, False)],
    ids=["the same time", "2^26 ms later", "five turns later", "another power-up"],
)
def test_recorded_commands_do_nothing_when_the_clock_shows_the_same(
    seed: int, options: dict[str, int], passes: bool
) -> None:
    heard = [frame for _, frame in order(skin(seed), 3)]
    again = skin(seed, **options)
    assert accepted(again, 3, heard[:1]) == passes
    assert accepted(again, 3, heard[1:]) == 2 * passes


def test_a_cell_without_a_name_obeys_nothing(seed: int) -> None:
    world, victim = skin(seed), 3
    heard = [frame for _, frame in order(world, victim)]
    world.boot(victim)
    keys = firmware.cell_keys(KEY, world.cell(victim).uid)
    for _ in range(40):
        if world.cell(victim).id:
            break
        tried = [*heard, signed(world, of_turn(keys[:16], 0), firmware.ID_ALL)]
        if world.cell(victim).parent_port:
            assert accepted(world, victim, tried) == 0
        world.run_ms(0.25)
    world.run_ms(40)
    assert world.cell(victim).id
    assert accepted(world, victim, heard) == 0


def test_a_turn_of_the_clock_changes_the_keys_and_loses_no_cell(seed: int) -> None:
    world = skin(seed, ahead_us=TURN_US - 3_100_000)
    assert (world.now + world.ahead_us) // TURN_US == 0
    heard = [frame for _, frame in order(world, 3)]
    world.run_ms(100)
    assert (world.now + world.ahead_us) // TURN_US == 1
    world.run_ms(1000)
    world.command("led", counter=4, value=4)
    world.run_ms(3)
    assert [node.led for node in world.nodes] == [4] * CELLS
    world.command("led", counter=5, target=world.cell(3).id, value=5)
    world.run_ms(3)
    assert world.nodes[3].led == 5
    assert accepted(world, 3, heard) == 0
