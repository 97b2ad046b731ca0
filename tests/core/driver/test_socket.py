# SPDX-License-Identifier: Apache-2.0
"""Over real UDP, with the driver's own thread: every frame that a sender with the key sends is taken."""

import threading
import time

import numpy as np
import pytest

from robotskin.driver import Driver
from robotskin_lab._lab.traffic import Traffic, send_traffic

KEY = bytes(range(32))
CELLS = 400


def free_port() -> int:
    return Driver([1], bind=("127.0.0.1", 0)).address[1]


@pytest.mark.parametrize("prepared", [False, True])
@pytest.mark.parametrize("records", [1, 69])
def test_the_thread_takes_every_frame(prepared: bool, records: int, seed: int) -> None:
    port = free_port()
    units = [("127.0.0.1", port)]
    driver = Driver(Traffic(CELLS).keys(), KEY, ("127.0.0.1", 0), units, session_seed=seed)
    driver.start()
    options = {"cells": CELLS, "rate_hz": 125, "key": KEY, "records_per_datagram": records, "prepared": prepared}
    sent = send_traffic(driver.address, ("127.0.0.1", port), 0.5, seed=seed, **options)
    driver.stop()
    driver.poll()
    counts = driver.statistics()
    assert sent["refused"] == 0
    assert counts["socket_dropped"] == 0
    assert counts["clock_frames"] == sent["frames"] > 0.4 * CELLS * 125
    assert counts["accepted"] + counts["unanswering"] == sent["datagrams"]
    assert driver.samples()["seen"].all()


def test_a_sender_with_another_key_is_not_heard_and_gives_up(seed: int) -> None:
    port = free_port()
    driver = Driver(Traffic(CELLS).keys(), KEY, ("127.0.0.1", 0), [("127.0.0.1", port)], session_seed=seed)
    driver.start()
    with pytest.raises(RuntimeError, match="no host has sent a keep-alive"):
        send_traffic(driver.address, ("127.0.0.1", port), 0.2, cells=CELLS, key=bytes(32), patience_s=0.5)
    driver.stop()
    assert driver.statistics()["accepted"] == 0
    assert not driver.samples()["seen"].any()


def test_snapshots_read_beside_the_thread_only_grow_younger(seed: int) -> None:
    port = free_port()
    driver = Driver(Traffic(CELLS).keys(), KEY, ("127.0.0.1", 0), [("127.0.0.1", port)], session_seed=seed)
    driver.start()
    options = {"cells": CELLS, "key": KEY, "seed": seed}
    sender = threading.Thread(
        target=send_traffic, args=(driver.address, ("127.0.0.1", port), 0.5), kwargs=options, daemon=True
    )
    sender.start()
    before, reads = np.zeros(CELLS, dtype=np.int64), 0
    while sender.is_alive():
        arrival_ns = driver.samples()["arrival_ns"]
        assert (arrival_ns >= before).all()
        reads += (arrival_ns > before).any()
        before = arrival_ns
        time.sleep(0)
    sender.join()
    driver.stop()
    assert reads > 10


def test_a_running_driver_says_what_it_cannot_do_beside_its_thread() -> None:
    driver = Driver([1], bind=("127.0.0.1", 0))
    driver.start()
    assert driver.running
    with pytest.raises(RuntimeError, match="poll while the driver's thread runs"):
        driver.poll()
    driver.stop()
    driver.stop()
    assert not driver.running
    with pytest.raises(RuntimeError, match="give `bind` when it is made"):
        Driver([1]).poll()
