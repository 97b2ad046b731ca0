# SPDX-License-Identifier: Apache-2.0
"""Events that cells send again after a failure: none counts twice, and no old one is taken for new."""

import random

import pytest

from robotskin.driver import Driver, Verdict
from robotskin_lab import firmware

MS = 1_000_000
START_NS = 10**12


class Unit:
    """A section unit without a key that sends given frames, one a datagram."""

    def __init__(self) -> None:
        self.sequence = 0

    def send(self, driver: Driver, now_ns: int, name: str, port: int = 1, **fields: int) -> None:
        content = firmware.pack(name, fields)[: firmware.CONTENT_BYTES]
        header = (
            firmware.DATAGRAM_MAGIC.to_bytes(4, "big")
            + bytes([firmware.DATAGRAM_VERSION, 1, 0, 0])
            + (9).to_bytes(4, "big")
            + self.sequence.to_bytes(4, "big")
            + now_ns.to_bytes(8, "big")
            + (1).to_bytes(2, "big")
            + bytes(10)
        )
        self.sequence += 1
        assert driver.handle(header + content + bytes([port << 4, 0]), now_ns) == Verdict.accepted

    def event(self, driver: Driver, now_ns: int, number: int, *, retransmitted: bool, sampled_ns: int) -> None:
        self.send(
            driver,
            now_ns,
            "event",
            source=1,
            sequence=number % 256,
            retransmitted=int(retransmitted),
            proximity=number,
            sample_tick=sampled_ns // MS % 16,
            sample_phase=sampled_ns % MS * 64 // MS,
        )


@pytest.mark.parametrize("trial", range(20))
def test_each_event_counts_once_and_the_newest_stays(trial: int, seed: int) -> None:
    draw = random.Random(seed * 100 + trial)
    driver, unit = Driver([1]), Unit()
    sampled = [START_NS + 2 * k * MS + draw.randrange(2 * MS) for k in range(150)]
    arrivals = []
    for number, time_ns in enumerate(sampled):
        lost = number > 0 and draw.random() < 0.1  # what comes before the first is not missed
        if not lost:
            arrivals.append((time_ns + draw.randrange(MS), number, False))
        if lost or draw.random() < 0.3:
            arrivals += [
                (time_ns + draw.randrange(2 * MS, 13 * MS), number, True) for _ in range(draw.choice((1, 1, 2)))
            ]
    arrivals.sort()
    newest = -1
    for now_ns, number, retransmitted in arrivals:
        unit.event(driver, now_ns, number, retransmitted=retransmitted, sampled_ns=sampled[number])
        newest = max(newest, number)
        driver.publish(now_ns)
        samples = driver.samples()
        assert samples["proximity"][0] == newest
        assert abs(samples["stamp_ns"][0] - sampled[newest]) < 2 * MS
    counts = driver.statistics()
    assert counts["event_frames"] + counts["frames_late"] == len(sampled)
    assert counts["frames_duplicated"] == len(arrivals) - len(sampled)
    assert counts["frames_missing"] == counts["frames_late"]


def test_a_repeated_event_is_old_even_after_a_silence() -> None:
    driver, unit = Driver([1]), Unit()
    unit.event(driver, START_NS, 7, retransmitted=False, sampled_ns=START_NS)
    late_ns = START_NS + 150 * MS
    unit.event(driver, late_ns, 7, retransmitted=True, sampled_ns=START_NS)
    driver.publish(late_ns)
    assert driver.samples()["arrival_ns"][0] == START_NS
    assert driver.statistics()["frames_duplicated"] == 1
