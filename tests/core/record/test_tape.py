# SPDX-License-Identifier: Apache-2.0
"""A tape waits for those that read it, and for nothing else."""

import numpy as np
import pytest

from robotskin import layout
from robotskin.model import JointState
from robotskin.record.entries import entries
from robotskin.record.tape import Entry, Recorder, TapeReader
from robotskin.record.tape_memory import TapeMemory

JOINTS = 7


class Tapes:
    """A recorder that takes down joints, and its readers."""

    def __init__(self, kib: int) -> None:
        self.memory = [TapeMemory.made("tape", kib / 1024).bytes for _ in range(2)]
        self.recorder, self.joints = Recorder(*self.memory), JointState(JOINTS)
        self.skin = layout.finished("ur5").skin_model()
        self.stamp_ns = 0

    def reader(self, number: int) -> TapeReader:
        self.recorder.begin_reading(number)
        return TapeReader(*self.memory, number, self.skin)

    def take_down(self, count: int) -> None:
        for _ in range(count):
            self.stamp_ns += 1
            self.joints.stamp_ns = self.stamp_ns
            self.recorder.moved(self.stamp_ns, self.joints, None)


def stamps(reader: TapeReader) -> list[int]:
    return [one.time_ns for one in entries(reader.drain_control()) if one.kind == Entry.joints.value]


def test_each_reader_finds_every_entry(seed: int) -> None:
    tapes, draw = Tapes(64), np.random.default_rng(seed)
    readers = [tapes.reader(0), tapes.reader(1)]
    found: list[list[int]] = [[], []]
    for _ in range(300):
        tapes.take_down(int(draw.integers(0, 40)))
        for number, reader in enumerate(readers):
            if draw.random() < 0.8:
                found[number] += stamps(reader)
    for number, reader in enumerate(readers):
        assert found[number] + stamps(reader) == list(range(1, tapes.stamp_ns + 1))
    assert tapes.recorder.dropped == 0


def test_a_reader_that_lags_drops_for_all_until_it_ends() -> None:
    tapes = Tapes(16)
    slow, fast = tapes.reader(0), tapes.reader(1)
    tapes.take_down(1000)
    assert tapes.recorder.dropped > 0
    stamps(fast)
    before = tapes.recorder.dropped
    tapes.take_down(10)
    assert tapes.recorder.dropped == before + 10
    tapes.recorder.end_reading(0)
    tapes.take_down(10)
    assert tapes.recorder.dropped == before + 10
    assert stamps(fast) == list(range(tapes.stamp_ns - 9, tapes.stamp_ns + 1))
    del slow


def test_memory_in_which_no_tape_can_be_is_refused() -> None:
    large = np.zeros(1 << 16, np.uint8)
    for small_or_askew in (np.zeros(100, np.uint8), large[1 + -large.ctypes.data % 64 :]):
        with pytest.raises(ValueError, match="aligned to 64 bytes"):
            Recorder(small_or_askew, TapeMemory.made("tape", 1).bytes)
    memory = TapeMemory.made("tape", 1).bytes
    with pytest.raises(ValueError, match="reader 2"):
        Recorder(memory, TapeMemory.made("tape", 1).bytes).begin_reading(2)
