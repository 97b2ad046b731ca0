# SPDX-License-Identifier: Apache-2.0
"""A damaged file whose messages lie about their time is mended like any other."""

from pathlib import Path

from mcap.writer import Writer

from robotskin.record.repairing import repair

TIMES_NS = (1_000_000, (1 << 64) - 1, 2_000_000)


def test_a_time_that_lies_beyond_any_clock_is_not_the_newest(tmp_path: Path) -> None:
    path = tmp_path / "lies.mcap"
    with path.open("wb") as file:
        writer = Writer(file, chunk_size=1)
        writer.start(library="robotskin")
        channel = writer.register_channel("/skin/tape", "x", 0)
        for number, time_ns in enumerate(TIMES_NS):
            writer.add_message(channel, time_ns, bytes(2000), time_ns, number)
        writer.finish()
    whole = path.read_bytes()
    path.write_bytes(whole[: len(whole) // 2] + b"\xff" * 16 + whole[len(whole) // 2 + 16 :])
    assert repair(path).newest_ns <= TIMES_NS[2]
