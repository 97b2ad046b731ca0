# SPDX-License-Identifier: Apache-2.0
"""Laws of the names that a section unit gives: as many cells as it can name get one, whatever their serial numbers."""

from test_section_unit import Bench

from robotskin_lab import firmware


def place_of(uid: int) -> int:
    """Where the table of names begins to look for a serial number (spread.h)."""
    uid ^= uid >> 16
    uid = uid * 0x7FEB352D & 0xFFFFFFFF
    uid ^= uid >> 15
    uid = uid * 0x846CA68B & 0xFFFFFFFF
    return (uid ^ uid >> 16) % (2 * firmware.UNIT_NAMES_MAX)


def named(bench: Bench, uids: list[int]) -> dict[int, int]:
    for uid in uids:
        bench.hear("join", uid=uid, challenge=uid & 0xFFFF)
    return bench.unit.names


def test_all_find_a_place_where_every_number_leads_to_every_other_one(seed: int) -> None:
    bench = Bench()
    bench.attach()
    even = [uid for uid in range(1 + 20_000 * seed, 20_000 + 20_000 * seed) if place_of(uid) % 2 == 0]
    uids = even[: firmware.UNIT_NAMES_MAX + 1]
    names = named(bench, uids)
    assert set(names) == set(uids[:-1])
    assert len(set(names.values())) == firmware.UNIT_NAMES_MAX


def test_a_unit_with_all_ports_in_use_forgets_no_name_while_it_levels() -> None:
    """The names stand in memory behind the ports."""
    bench = Bench(15)
    for port in range(1, 16):
        bench.attach(port)
    uids = [uid for uid in range(1, 60_000) if place_of(uid) < 400]
    names = named(bench, uids)
    assert set(names) == set(uids)
    for _ in range(60):
        for port in range(1, 16):
            bench.attach(port)
            bench.hear("status", port, sender=9, size=1)
        bench.run_us(3000)
    assert bench.unit.names == names
