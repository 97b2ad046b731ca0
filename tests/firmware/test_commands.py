# SPDX-License-Identifier: Apache-2.0
"""Commands take effect exactly once; forged and replayed ones never do."""

import random

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from small_world import SmallWorld, random_skin
from test_sampling import Feeder, tick

from robotskin_lab import firmware

OPERATION = {name: number for name, number, *_ in firmware.OPERATIONS}
STATUS = {name: number for name, number, *_ in firmware.REPLY_STATUSES}
KEY = bytes(range(16))


def replies(world: SmallWorld) -> list[dict[str, int]]:
    return [fields for _, _, name, fields in world.records if name == "reply"]


@pytest.fixture
def skin(seed: int) -> SmallWorld:
    links, roots = random_skin(15, 2, seed)
    world = SmallWorld(15, links, roots, seed)
    world.run_ms(50)
    world.records.clear()
    return world


def test_a_command_to_all_reaches_every_cell_once(skin: SmallWorld) -> None:
    skin.command("led", counter=5, value=0x123456)
    skin.run_ms(3)
    assert [node.led for node in skin.nodes] == [0x123456] * 15
    assert replies(skin) == []
    skin.command("ping", counter=6)
    skin.run_ms(4)
    assert sorted(reply["source"] for reply in replies(skin)) == sorted(skin.cell(index).id for index in range(15))


def test_a_command_to_one_changes_one_and_is_answered(skin: SmallWorld) -> None:
    target = skin.cell(7).id
    skin.command("threshold", counter=5, target=target, index=2, value=77)
    skin.run_ms(3)
    (reply,) = replies(skin)
    assert (reply["source"], reply["status"], reply["counter"]) == (target, STATUS["done"], 5)
    for index in range(15):
        skin.records.clear()
        skin.command("read", counter=6 + index, target=skin.cell(index).id, index=2, value=OPERATION["threshold"])
        skin.run_ms(3)
        (reply,) = replies(skin)
        default = dict(firmware.EVENT_THRESHOLDS)["force_2"]
        assert reply["value_low"] == (77 if index == 7 else default)


def test_the_same_counter_is_answered_again_but_done_once(skin: SmallWorld) -> None:
    target = skin.cell(3).id
    skin.command("led", counter=9, target=target, value=1)
    skin.run_ms(3)
    skin.nodes[3].led = -1
    skin.command("led", counter=9, target=target, value=1)
    skin.command("led", counter=9, target=target, value=2)
    skin.run_ms(3)
    assert len(replies(skin)) == 3
    assert skin.nodes[3].led == -1


def test_a_command_for_one_child_does_not_wait_for_the_line_of_another() -> None:
    feeder, now = Feeder(), 5_000_000
    feeder.take(feeder.cell.boot(77, 1, now), now)
    for _ in range(12):
        now += 1000
        feeder.tick(now)
        for port in (2, 3):
            child = tick(feeder.sequence, sender=40 + port, parent=1, hops=2)
            feeder.take(feeder.cell.frame(port, child, now), now)
    passed_on: dict[int, list[int]] = {2: [], 3: []}

    def take(output: firmware.CellOutput) -> None:
        for port, counters in passed_on.items():
            if output.frames[port - 1] is not None:
                counters.append(firmware.unpack(output.frames[port - 1])[1]["counter"])

    for counter in range(5, 10):
        fields = {"operation": OPERATION["led"], "counter": counter, "target": firmware.ID_ALL}
        take(feeder.cell.frame(1, firmware.pack("command", fields), now))
    for _ in range(6):
        now += 50
        take(feeder.cell.sent(2, now))
    assert passed_on == {2: [5, 6, 7, 8, 9], 3: [5]}
    for _ in range(6):
        now += 50
        take(feeder.cell.sent(3, now))
    assert passed_on[3] == passed_on[2]


def test_an_old_counter_does_nothing(skin: SmallWorld) -> None:
    for counter, value, expected in ((100, 1, 1), (99, 2, 1), (65000, 3, 1), (101, 4, 4), (30000, 5, 5), (50000, 6, 6)):
        skin.command("led", counter=counter, value=value)
        skin.run_ms(3)
        assert {node.led for node in skin.nodes} == {expected}


@pytest.mark.parametrize(
    ("operation", "index", "value", "status"),
    [
        ("clock_rate", 0, 100, "bad_value"),
        ("mode", 0, 2, "bad_value"),
        ("event_rate", 0, 7, "bad_value"),
        ("event_rate", 0, 1001, "bad_value"),
        ("threshold", 9, 5, "bad_index"),
        ("threshold", 0, 0, "bad_value"),
        ("threshold", 0, 65536, "bad_value"),
        ("event_mask", 0, 512, "bad_value"),
        ("offset", 0, 32768, "bad_value"),
        ("offset", 20, 0, "bad_index"),
        ("led", 0, 0x1000000, "bad_value"),
        ("led", 1, 0, "bad_index"),
        ("read", 0, 63, "bad_value"),
        ("read", 9, OPERATION["threshold"], "bad_index"),
        ("read", 1, OPERATION["led"], "bad_index"),
        ("read", 8, OPERATION["threshold"], "done"),
        ("threshold", 8, 65535, "done"),
        ("offset", 4, -32768, "done"),
    ],
)
def test_impossible_values_are_refused_and_named(operation: str, index: int, value: int, status: str) -> None:
    feeder, now = named_cell()
    feeder.command(operation, 1, now, target=33, index=index, value_low=value & 0xFFFFFFFF)
    (reply,) = [fields for name, fields in map(firmware.unpack, feeder.sent) if name == "reply"]
    assert reply["status"] == STATUS[status]


def test_an_unknown_operation_is_answered_as_such() -> None:
    feeder, now = named_cell()
    frame = firmware.pack("command", {"operation": 50, "counter": 1, "target": 33})
    feeder.take(feeder.cell.frame(1, frame, now), now)
    (reply,) = [fields for name, fields in map(firmware.unpack, feeder.sent) if name == "reply"]
    assert reply["status"] == STATUS["unknown_operation"]


def test_an_offset_is_added_to_what_is_sent() -> None:
    feeder, now = named_cell()
    feeder.command("offset", 1, now, index=4, value_low=-100 & 0xFFFFFFFF)
    feeder.sent.clear()
    feeder.take(feeder.cell.sample([50] * 9, now + 500), now + 500)
    (sample,) = [fields for name, fields in map(firmware.unpack, feeder.sent) if name == "clock"]
    assert (sample["acceleration_x"], sample["acceleration_y"]) == (-50, 50)


def test_settings_survive_a_power_cycle_if_stored_and_a_damaged_image_does_not(seed: int) -> None:
    feeder, now = named_cell()
    feeder.command("mode", 1, now, value_low=1)
    feeder.command("threshold", 2, now, index=0, value_low=4321)
    frame = firmware.pack("command", {"operation": OPERATION["store"], "counter": 3, "target": 33})
    image = feeder.cell.frame(1, frame, now).flash
    assert image is not None
    assert len(image) == firmware.FLASH_BYTES
    for flash, expected in ((image, 4321), (bytes([image[0]]) + bytes([image[1] ^ 1]) + image[2:], 7), (None, 7)):
        again, later = named_cell(flash=flash)
        again.command("read", 1, later, target=33, index=0, value_low=OPERATION["threshold"])
        (reply,) = [fields for name, fields in map(firmware.unpack, again.sent) if name == "reply"]
        assert reply["value_low"] == expected


def test_every_setting_that_is_stored_comes_back_as_it_was(seed: int) -> None:
    draw = random.Random(seed)
    wanted = {("mode", 0): 1, ("event_rate", 0): 500, ("event_mask", 0): draw.randrange(1, 512)}
    for channel in range(len(firmware.EVENT_THRESHOLDS)):
        wanted["threshold", channel] = draw.randrange(1, 65536)
        wanted["offset", channel] = draw.randrange(-32768, 32768)
    feeder, now = named_cell()
    for counter, ((name, index), value) in enumerate(wanted.items(), 1):
        feeder.command(name, counter, now, index=index, value_low=value & 0xFFFFFFFF)
    frame = firmware.pack("command", {"operation": OPERATION["store"], "counter": len(wanted) + 1, "target": 33})
    again, later = named_cell(flash=feeder.cell.frame(1, frame, now).flash)
    for counter, ((name, index), value) in enumerate(wanted.items(), 1):
        again.sent.clear()
        again.command("read", counter, later, target=33, index=index, value_low=OPERATION[name])
        (reply,) = [fields for told, fields in map(firmware.unpack, again.sent) if told == "reply"]
        assert (reply["value_low"] ^ value) & 0xFFFF == 0, (name, index)


@settings(max_examples=200)
@given(frame=st.binary(min_size=18, max_size=18), port=st.integers(2, 4))
def test_commands_from_elsewhere_than_the_parent_are_ignored(frame: bytes, port: int) -> None:
    feeder, now = named_cell()
    content = bytes([OPERATION_TYPE << 4 | frame[0] & 15]) + frame[1:]
    before = feeder.cell.counts["frames_unknown"]
    output = feeder.cell.frame(port, content + firmware.crc16(content).to_bytes(2, "big"), now)
    assert output.led_rgb is None
    assert output.flash is None
    assert feeder.cell.counts["frames_unknown"] == before + 1


# ---- With a key ----


@pytest.fixture
def keyed(seed: int) -> SmallWorld:
    links, roots = random_skin(10, 2, seed)
    world = SmallWorld(10, links, roots, seed, key=KEY)
    world.run_ms(50)
    return world


def test_with_a_key_the_skin_works_as_without(keyed: SmallWorld) -> None:
    assert len({keyed.cell(index).id for index in range(10)} - {0}) == 10
    keyed.command("led", counter=1, value=9)
    keyed.run_ms(3)
    assert [node.led for node in keyed.nodes] == [9] * 10
    assert all(keyed.cell(index).counts["tags_refused"] == 0 for index in range(10))


def test_forged_commands_and_ticks_do_nothing(keyed: SmallWorld) -> None:
    victim = next(index for index in range(10) if keyed.parent(index) == -1)
    cell = keyed.cell(victim)
    port = cell.parent_port
    for tag in (0, 1, 0xDEADBEEF):
        forged = {"operation": OPERATION["led"], "counter": 9, "target": firmware.ID_ALL, "value_low": 5, "tag": tag}
        keyed.cell_done(victim, cell.frame(port, firmware.pack("command", forged), keyed.now))
        tick = {"sequence": cell.sequence + 1 & 0xFFFF, "root": 1, "sender": 16383, "heard": 1, "gain_threshold": 1}
        before = cell.sequence
        nonce = 4711 & 0xFF
        keyed.cell_done(
            victim, cell.frame(port, firmware.pack("tick", {**tick, "nonce": nonce, "tag": tag}), keyed.now)
        )
        assert cell.sequence == before
    assert keyed.nodes[victim].led == 0
    assert cell.counts["tags_refused"] == 6
    assert cell.parent_port == port


def test_recorded_commands_and_ticks_played_again_do_nothing(keyed: SmallWorld) -> None:
    victim = next(index for index in range(10) if keyed.parent(index) == -1)
    cell = keyed.cell(victim)
    keyed.heard_frames.clear()
    for counter in (1, 2):
        keyed.command("led", counter=counter, value=counter)
        keyed.run_ms(3)
    heard = [(port, frame) for (index, port), frame in keyed.heard_frames if index == victim]
    commands = [(port, frame) for port, frame in heard if firmware.unpack(frame)[0] == "command"]
    ticks = [(port, frame) for port, frame in heard if firmware.unpack(frame)[0] == "tick" and port == cell.parent_port]
    assert len(commands) == 2
    assert keyed.nodes[victim].led == 2
    for port, frame in commands:
        keyed.cell_done(victim, cell.frame(port, frame, keyed.now))
    assert keyed.nodes[victim].led == 2
    # 70 seconds later the counter has come round for no cell, but the era has gone: even a rebooted cell is safe.
    keyed.now += 70_000_000
    fresh = keyed.nodes[victim]
    keyed.unit_done(keyed.unit.timer(keyed.now * 1000))
    for index in range(10):
        keyed.boot(index)
    keyed.run_ms(60)
    assert fresh.cell is not None
    assert fresh.cell.parent_port == commands[0][0]
    before = fresh.cell.counts["tags_refused"]
    for port, frame in commands:
        keyed.cell_done(victim, fresh.cell.frame(port, frame, keyed.now))
    assert fresh.led == 2  # as it was before; the cell's own LED was never set again
    assert fresh.cell.counts["tags_refused"] == before + 2
    sequence = fresh.cell.sequence
    keyed.cell_done(victim, fresh.cell.frame(*ticks[-1], keyed.now))
    assert fresh.cell.sequence == sequence
    assert fresh.cell.counts["tags_refused"] == before + 3


OPERATION_TYPE = {name: number for name, number, *_ in firmware.FRAME_TYPES}["command"]


def named_cell(flash: bytes | None = None) -> tuple[Feeder, int]:
    feeder = Feeder()
    now = 5_000_000
    feeder.take(feeder.cell.boot(77, 1, now, flash=flash), now)
    for _ in range(12):
        now += 1000
        feeder.tick(now)
    feeder.command("assign", 0, now, index=33, value_low=77, value_high=feeder.cell.challenge)
    assert feeder.cell.id == 33
    feeder.sent.clear()
    return feeder, now


def test_an_id_is_given_up_once_however_often_the_command_comes() -> None:
    feeder, now = named_cell()
    feeder.command("rejoin", 0, now, index=34, value_low=77)
    assert feeder.cell.id == 33  # the doubt was about another id
    feeder.command("rejoin", 0, now, index=33, value_low=77)
    assert feeder.cell.id == firmware.ID_NONE
    feeder.command("assign", 0, now, index=35, value_low=77, value_high=feeder.cell.challenge)
    feeder.command("rejoin", 0, now, index=33, value_low=77)
    assert feeder.cell.id == 35
