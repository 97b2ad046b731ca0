# SPDX-License-Identifier: Apache-2.0
"""Frames of further channels go through cells that have no such sensors as clock samples do."""

from small_world import SmallWorld

from robotskin_lab import firmware

CELLS = 6


def test_they_pass_cells_without_such_sensors(seed: int) -> None:
    """On a line, the last cell's clock samples are made further frames where they begin."""
    links = [((cell, 1), (cell + 1, 3)) for cell in range(CELLS - 1)]
    world = SmallWorld(CELLS, links, [(0, 3)], seed, loss=0.001)
    made: list[int] = []

    def tamper(end: tuple[int, int], frame: bytes) -> bytes:
        if end[0] != CELLS - 1 or frame[0] >> 4 != 1:
            return frame
        _, fields = firmware.unpack(frame)
        if fields["sequence"] % 2:
            return frame
        kept = {name: fields[name] for name in ("source", "sequence", "ttl", "sample_tick", "sample_phase")}
        made.append(fields["sequence"])
        return firmware.pack("further", kept | {"value_1": 48000 + fields["sequence"], "value_6": 65535, "fault": 1})

    world.run_ms(100)
    world.tamper = tamper
    before = len(world.records)
    world.run_ms(400)
    source = world.nodes[CELLS - 1].cell.id
    heard = [fields for _, _, name, fields in world.records[before:] if name == "further"]
    assert len(made) > 40
    # Lines lose one frame in a thousand.
    assert len(made) - 5 <= len(heard) <= len(made)
    for fields in heard:
        assert (fields["source"], fields["value_6"], fields["fault"]) == (source, 65535, 1)
        assert fields["value_1"] == 48000 + fields["sequence"]
        assert fields["ttl"] == firmware.TTL_START - (CELLS - 1)
    numbers = [fields["sequence"] for fields in heard]
    assert numbers == [number for number in made if number in set(numbers)]
    # They take no other cell's place.
    others = [fields for _, _, name, fields in world.records[before:] if name == "clock" and fields["source"] != source]
    assert len(others) > 0.97 * 75 * (CELLS - 1)
