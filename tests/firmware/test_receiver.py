# SPDX-License-Identifier: Apache-2.0
"""Frames are found in a stream of bytes by their checksum: damage and lost bytes cost a few frames, never the rest."""

from hypothesis import given, settings
from hypothesis import strategies as st

from robotskin_lab import firmware


def frames(count: int, start: int = 0) -> list[bytes]:
    return [
        firmware.pack("clock", {"source": 1 + i, "proximity": 7 * i, "ttl": 63}) for i in range(start, start + count)
    ]


def test_a_clean_line_gives_every_frame() -> None:
    sent = frames(50)
    assert firmware.Receiver().feed(b"".join(sent)) == sent


@settings(max_examples=60)
@given(
    position=st.integers(0, 20 * 20 - 1),
    removed=st.integers(0, 30),
    inserted=st.binary(max_size=30),
)
def test_after_lost_and_foreign_bytes_frames_are_found_again(position: int, removed: int, inserted: bytes) -> None:
    sent = frames(20)
    line = b"".join(sent)
    later = frames(6, 100)
    found = firmware.Receiver().feed(line[:position] + inserted + line[position + removed :] + b"".join(later))
    assert set(found) <= set(sent + later)
    # Whole before the damage, and whole again from the second frame after it.
    assert found[: position // 20] == sent[: position // 20]
    assert found[-4:] == later[-4:]


@given(position=st.integers(0, 159), start=st.integers(0, 1000))
def test_a_damaged_bit_costs_at_most_two_frames(position: int, start: int) -> None:
    sent = frames(10, start)
    damaged = bytearray(b"".join(sent))
    damaged[40 + position // 8] ^= 0x80 >> position % 8
    found = firmware.Receiver().feed(bytes(damaged))
    assert found == sent[:2] + sent[4:]


def test_a_pause_marks_the_start_of_a_frame() -> None:
    receiver = firmware.Receiver()
    sent = frames(3)
    assert receiver.feed(sent[0][:7]) == []
    assert receiver.idle()
    assert receiver.feed(sent[1]) == [sent[1]]
    assert not receiver.idle()
    assert receiver.feed(sent[2]) == [sent[2]]
