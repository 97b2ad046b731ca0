# SPDX-License-Identifier: Apache-2.0
"""Laws of frames: they fill their bits, decoding inverts encoding, and the checksum keeps its distance."""

from itertools import combinations

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from robotskin_lab import firmware

FRAMES = sorted(firmware.FRAMES)


def number(signed: bool, bits: int) -> st.SearchStrategy[int]:
    return st.integers(-(2 ** (bits - 1)), 2 ** (bits - 1) - 1) if signed else st.integers(0, 2**bits - 1)


def fields_of(name: str) -> st.SearchStrategy[dict[str, int]]:
    types = {frame: number for frame, number, _ in firmware.FRAME_TYPES}
    return st.fixed_dictionaries(
        {
            field: st.just(types[name]) if field == "type" else number(signed, bits)
            for field, signed, bits, _ in firmware.FRAMES[name]
        }
    )


def crc_by_bits(data: bytes) -> int:
    register = firmware.CRC_START
    for byte in data:
        register ^= byte << 8
        for _ in range(8):
            register <<= 1
            if register & 0x10000:
                register ^= firmware.CRC_POLYNOMIAL
    return register


@pytest.mark.parametrize("name", FRAMES)
def test_fields_fill_the_content(name: str) -> None:
    assert sum(bits for _, _, bits, _ in firmware.FRAMES[name]) == firmware.CONTENT_BITS == 144
    assert firmware.CONTENT_BITS + 16 == 8 * firmware.FRAME_BYTES == 160


@pytest.mark.parametrize("name", FRAMES)
@settings(max_examples=25)
@given(data=st.data())
def test_decode_inverts_encode(name: str, data: st.DataObject) -> None:
    fields = data.draw(fields_of(name))
    frame = firmware.pack(name, fields)
    assert len(frame) == firmware.FRAME_BYTES
    assert firmware.unpack(frame) == (name, fields)


@pytest.mark.parametrize("name", FRAMES)
@settings(max_examples=25)
@given(data=st.data())
def test_fields_stand_where_the_table_says(name: str, data: st.DataObject) -> None:
    fields = data.draw(fields_of(name))
    word = int.from_bytes(firmware.pack(name, fields), "big")
    at = 0
    for field, _, bits, _ in firmware.FRAMES[name]:
        assert word >> (160 - at - bits) & (2**bits - 1) == fields[field] % 2**bits, field
        at += bits


def test_a_number_out_of_range_is_refused_by_name() -> None:
    with pytest.raises(ValueError, match=r"tick\.hops = 256 is not in 0 to 255"):
        firmware.pack("tick", {"hops": 256})
    with pytest.raises(ValueError, match="tick has no field hop"):
        firmware.pack("tick", {"hop": 1})
    with pytest.raises(ValueError, match="no frame is called tock"):
        firmware.pack("tock", {})
    with pytest.raises(ValueError, match="20 bytes, not 3"):
        firmware.unpack(b"abc")


@given(st.binary(max_size=70))
def test_the_fast_checksum_equals_the_plain_one(data: bytes) -> None:
    assert firmware.crc16(data) == crc_by_bits(data)


def test_checksum_distance_is_five_at_160_bits() -> None:
    """No error of one to four bits goes unseen.

    The checksum is linear, so an error goes unseen exactly if the syndromes of its bits cancel: one is zero, two are
    equal, one is the sum of two others, or two pairs have the same sum.
    """
    syndrome = []
    value = 1
    for _ in range(160):
        syndrome.append(value)
        value <<= 1
        if value & 0x10000:
            value ^= firmware.CRC_POLYNOMIAL
    singles = set(syndrome)
    assert 0 not in singles
    assert len(singles) == 160
    pairs = [a ^ b for a, b in combinations(syndrome, 2)]
    assert not singles & set(pairs)
    assert len(set(pairs)) == len(pairs)
    # And the code is not better than claimed, so the test sees what it looks at.
    assert any(a ^ b ^ c in set(pairs) for a, b, c in combinations(syndrome[:60], 3))


def test_the_syndromes_are_those_of_the_frame() -> None:
    frame = firmware.pack("clock", {"source": 5})
    for bit in range(160):
        damaged = bytearray(frame)
        damaged[bit // 8] ^= 0x80 >> bit % 8
        with pytest.raises(ValueError, match="checksum"):
            firmware.unpack(bytes(damaged))


def test_a_silent_line_is_no_frame() -> None:
    for byte in (0x00, 0xFF):
        with pytest.raises(ValueError):
            firmware.unpack(bytes([byte]) * 20)


@pytest.mark.parametrize("name", FRAMES)
@settings(max_examples=25)
@given(data=st.data())
def test_taking_a_hop_changes_only_the_time_to_live(name: str, data: st.DataObject) -> None:
    fields = data.draw(fields_of(name))
    shorter = firmware.take_hop(firmware.pack(name, fields))
    if fields.get("ttl", 0) == 0:
        assert shorter is None
    else:
        assert firmware.unpack(shorter) == (name, {**fields, "ttl": fields["ttl"] - 1})


def test_a_sample_takes_98_bits() -> None:
    assert sum(bits for _, _, bits, _, _ in firmware.CHANNELS) == 98
    layout = {field: (signed, bits) for field, signed, bits, _ in firmware.FRAMES["clock"]}
    for name, signed, bits, _, _ in firmware.CHANNELS:
        assert layout[name] == (signed, bits)


def test_66_cells_load_a_port_to_82_5_percent() -> None:
    frame_us = 8 * firmware.FRAME_BYTES * firmware.LINK_BITS_PER_BYTE / 8 / firmware.LINK_BAUD * 1e6
    assert frame_us == firmware.FRAME_US == 50
    assert firmware.CELLS_PER_PORT * 250 * frame_us * 1e-6 == pytest.approx(0.825)
