# SPDX-License-Identifier: Apache-2.0
"""Laws of damaged memory: where a cell keeps sums no bit that turns goes unseen, and what cannot be is healed.

What a cell is told to do gives no damaged memory, so its functions are called by their own names.
"""

import ctypes
import random
import struct

import pytest
from test_keys import KEY, skin
from test_queues import Crowded
from test_route import cell_between
from test_sampling import lone_event_cell

from robotskin_lab import _lab, firmware

QUEUE_DATA = 64
FIRMWARE = ctypes.CDLL(_lab.__file__)
FIRMWARE.rs_sum_of.argtypes = (ctypes.c_void_p, ctypes.c_uint32)
FIRMWARE.rs_sum_of.restype = ctypes.c_uint32
FIRMWARE.rs_cell_sealed.argtypes = (ctypes.c_void_p,)
FIRMWARE.rs_cell_sealed.restype = ctypes.c_bool
for check in (FIRMWARE.rs_route_check, FIRMWARE.rs_queues_check):
    check.argtypes = (ctypes.c_void_p, ctypes.c_uint32)
    check.restype = None
FIRMWARE.rs_sampling_take.argtypes = (ctypes.c_void_p, ctypes.c_void_p, ctypes.c_bool, ctypes.c_uint32)
FIRMWARE.rs_sampling_take.restype = None


def sum_of(halfwords: bytes) -> int:
    return FIRMWARE.rs_sum_of(
        (ctypes.c_uint64 * (len(halfwords) // 8 + 1)).from_buffer_copy(halfwords + bytes(8)), len(halfwords)
    )


@pytest.mark.parametrize("count", [2, 8, 46, 300])
def test_a_sum_tells_any_bit_of_what_it_is_of(count: int, seed: int) -> None:
    draw = random.Random(seed)
    for whole in (bytes(count), b"\xff" * count, draw.randbytes(count)):
        for bit in range(8 * count):
            turned = bytearray(whole)
            turned[bit // 8] ^= 1 << bit % 8
            assert sum_of(bytes(turned)) != sum_of(whole), bit


def test_no_sum_is_zero() -> None:
    """That means that there is nothing that it could be of; these bytes would come to it."""
    assert sum_of(bytes.fromhex("6cb40feea20b2b4ad8b1")) == 1


def test_a_cell_is_not_what_it_was_if_any_bit_of_its_name_or_keys_turns(seed: int) -> None:
    world = skin(seed)
    cell = world.cell(0)
    state = bytearray(cell.state)
    keys = firmware.cell_keys(KEY, cell.uid)
    of_ticks, of_all = bytes(state).find(keys[:16]), bytes(state).find(keys)
    assert 0 < of_ticks < of_all
    memory = (ctypes.c_uint64 * (len(state) // 8)).from_buffer(state)
    assert FIRMWARE.rs_cell_sealed(memory)
    # Serial number and name, and from the keys of ticks on to the number of the turn.
    for at in (*range(6), *range(of_ticks, of_all + len(keys) + 4)):
        for bit in range(8):
            state[at] ^= 1 << bit
            assert not FIRMWARE.rs_cell_sealed(memory), (at, bit)
            state[at] ^= 1 << bit
    assert FIRMWARE.rs_cell_sealed(memory)


@pytest.mark.parametrize(("hops", "unbound"), [(0, 0), (firmware.HOPS_POISON, 0), (5, 1)])
def test_a_way_of_no_length_is_found_anew_at_the_next_check(hops: int, unbound: int) -> None:
    """A cell that has a parent has a distance."""
    cell, now = cell_between({1: 4, 2: 5})
    _, sequence, nearest = cell.feasible_distance
    state = bytearray(cell.state)
    said = struct.pack("<HBBBBB", sequence, nearest, cell.hops, cell.parent_port, 0, 0)
    at = state.index(said)
    memory = (ctypes.c_uint64 * (len(state) // 8)).from_buffer(state)
    state[at + 3], state[at + 6] = hops, unbound
    FIRMWARE.rs_route_check(memory, now)
    assert (state[at + 3], state[at + 4], state[at + 6]) in ((5, 1, 0), (6, 2, 0))


@pytest.mark.parametrize(("waiting", "sent", "kept"), [(30, 34, True), (30, 35, False), (5, 59, True), (5, 60, False)])
def test_no_more_samples_are_kept_that_were_sent_than_there_is_room_for(waiting: int, sent: int, kept: bool) -> None:
    bench = Crowded()
    for source in range(100, 107):
        bench.hear(2, firmware.pack("clock", {"source": source, "ttl": 63}))
    bench.keeps_busy = True
    for source in range(200, 201 + waiting):  # the first of them goes out
        bench.hear(2, firmware.pack("clock", {"source": source, "ttl": 63}))
    state = bytearray(bench.cell.state)
    most_sent_again = bytes([QUEUE_DATA, 8, 0])
    assert (bench.cell.waiting[1], state.count(most_sent_again)) == (waiting, 1)
    at = state.index(most_sent_again) + 1
    memory = (ctypes.c_uint64 * (len(state) // 8)).from_buffer(state)
    state[at] = sent
    FIRMWARE.rs_queues_check(memory, bench.now)
    assert state[at] == (sent if kept else 0)


def test_a_cell_that_has_lost_its_rate_samples_no_more_until_that_is_healed() -> None:
    feeder, now = lone_event_cell(event_rate=500)
    state = bytearray(feeder.cell.state)
    mode_and_rates = struct.pack("<BBH", 1, 250, 500)
    at = state.index(mode_and_rates)  # then in what is kept in flash
    state[at + 1 : at + 4] = bytes(3)
    memory = (ctypes.c_uint64 * (len(state) // 8)).from_buffer(state)
    lost = bytes(state)
    FIRMWARE.rs_sampling_take(memory, (ctypes.c_int32 * 32)(), False, now)
    assert [pair for pair in zip(lost, state, strict=True) if pair[0] != pair[1]] == [(1, 0)]  # it runs no more
