# SPDX-License-Identifier: Apache-2.0
"""The table by which simulated cells take their time is that of this firmware."""

import pytest

from robotskin.simulator import INPUT_KINDS, Processor, processing_ns
from robotskin.world.ideal import cells_take_time
from robotskin_lab.bench.firmware_chip import CLOCK_HZ
from robotskin_lab.bench.input_cycles import COLUMNS, counted, filled

# Those that come in every skin alike; others depend on what the skin does.
STEADY = (("clock", 0), ("clock", 1), ("tick", 0), ("wave", 3), ("wave", 4), ("joints", 0), ("torque", 0))


def test_the_worlds_table_is_of_this_firmware(seed: int) -> None:
    with cells_take_time():
        table = filled(counted(seed, 0.1))
    assert list(table) == list(INPUT_KINDS)
    for processor, which in ((Processor.zero_wait_states, 0), (Processor.one_wait_state, 1)):
        for kind, frames in STEADY:
            us = 1e6 * table[kind][which][frames] / CLOCK_HZ
            assert processing_ns(processor, kind, frames) == pytest.approx(1e3 * us, rel=0.1), (kind, frames)


def test_one_wait_state_takes_longer_and_more_frames_too() -> None:
    for kind in INPUT_KINDS:
        for frames in range(COLUMNS):
            zero, one = (processing_ns(p, kind, frames) for p in (Processor.zero_wait_states, Processor.one_wait_state))
            assert 0 < zero <= one
            assert processing_ns(Processor.none, kind, frames) == 0
    with pytest.raises(ValueError, match="INPUT_KINDS"):
        processing_ns(Processor.none, "thought", 0)
