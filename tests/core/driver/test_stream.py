# SPDX-License-Identifier: Apache-2.0
"""The table of the newest samples is what the section units sent, whatever happens to the datagrams on their way."""

import random

import numpy as np
import pytest

from robotskin.driver import Driver, Verdict
from robotskin_lab._lab.traffic import Traffic

MS = 1_000_000
START_NS = 10**12


def connected(cells: int, key: bytes | None, seed: int, **options: int) -> tuple[Traffic, Driver, int]:
    traffic = Traffic(cells, key=key, seed=seed, **options)
    driver = Driver(traffic.keys(), key, session_seed=seed)
    # Keep-alive, a first datagram that answers no session, a keep-alive that answers it.
    while not traffic.connected:
        for _, _, datagram in driver.downlink(START_NS):
            traffic.hear(datagram)
        if not traffic.connected:
            for datagram in traffic.step(START_NS):
                assert driver.handle(datagram, START_NS) == Verdict.unanswering
    return traffic, driver, START_NS


def stream(traffic: Traffic, now_ns: int, steps: int) -> list[tuple[int, bytes]]:
    """Return datagrams with the time at which they left."""
    datagrams = []
    for step in range(1, steps + 1):
        datagrams += [(now_ns + step * MS, datagram) for datagram in traffic.step(now_ns + step * MS)]
    end_ns = now_ns + (steps + 1) * MS
    return datagrams + [(end_ns, datagram) for datagram in traffic.flush(end_ns)]


def assert_table_is_what_was_sent(driver: Driver, traffic: Traffic) -> None:
    samples, sent = driver.samples(), traffic.sent()
    for name, values in sent.items():
        np.testing.assert_array_equal(samples[name], values, err_msg=name)


KEYS = [None, bytes(range(32))]


@pytest.mark.parametrize("key", KEYS, ids=["open", "keyed"])
@pytest.mark.parametrize("event_mode", [False, True])
def test_snapshot_is_the_plain_decode(key: bytes | None, event_mode: bool, seed: int) -> None:
    traffic, driver, now_ns = connected(700, key, seed, event_mode=event_mode)
    for sent_ns, datagram in stream(traffic, now_ns, 40):
        assert driver.handle(datagram, sent_ns + 30_000) == Verdict.accepted
    driver.publish(now_ns + 50 * MS)
    assert_table_is_what_was_sent(driver, traffic)
    assert driver.statistics()["frames_missing"] == 0
    assert driver.statistics()["datagrams_lost"] == 0


@pytest.mark.parametrize("key", KEYS, ids=["open", "keyed"])
@pytest.mark.parametrize("trial", range(5))
def test_order_duplicates_and_loss_do_not_matter(key: bytes | None, trial: int, seed: int) -> None:
    traffic, driver, now_ns = connected(700, key, seed + 1000 * trial)
    draw = random.Random(seed + trial)
    datagrams = stream(traffic, now_ns, 30)
    # Loss may take anything but a cell's last frame; duplicates and delays of up to 10 ms anything.
    keep_from = len(datagrams) - len(datagrams) // 4
    arrivals = []
    for number, (sent_ns, datagram) in enumerate(datagrams):
        for _ in range(draw.choice([0, 1, 1, 2, 3]) if number < keep_from else draw.choice([1, 2])):
            arrivals.append((sent_ns + draw.randrange(10 * MS), datagram))
    arrivals.sort(key=lambda arrival: arrival[0])
    for arrived_ns, datagram in arrivals:
        driver.handle(datagram, arrived_ns)
    driver.publish(now_ns + 50 * MS)
    assert_table_is_what_was_sent(driver, traffic)
    counts = driver.statistics()
    assert counts["accepted"] == len({datagram for _, datagram in arrivals})
    assert counts["duplicated"] == len(arrivals) - counts["accepted"]


@pytest.mark.parametrize("key", KEYS, ids=["open", "keyed"])
def test_a_replayed_stream_changes_nothing(key: bytes | None, seed: int) -> None:
    traffic, driver, now_ns = connected(300, key, seed)
    datagrams = stream(traffic, now_ns, 1500)
    for sent_ns, datagram in datagrams:
        driver.handle(datagram, sent_ns)
    driver.publish(now_ns)
    before, counts = driver.samples(), driver.statistics()
    later_ns = now_ns + 2000 * MS
    assert {driver.handle(datagram, later_ns) for _, datagram in datagrams} <= {Verdict.duplicated, Verdict.replayed}
    driver.publish(later_ns)
    after = driver.samples()
    for name in before:
        np.testing.assert_array_equal(before[name], after[name], err_msg=name)
    assert driver.statistics()["frames"] == counts["frames"]
