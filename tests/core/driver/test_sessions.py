# SPDX-License-Identifier: Apache-2.0
"""Which units are believed: tags, sessions and restarts; what is refused changes nothing."""

import hashlib
import random

import numpy as np
import pytest

from robotskin.driver import Driver, Verdict, keyed_tag
from robotskin.errors import InputError, UnknownNameError
from robotskin_lab._lab.traffic import Traffic

MS = 1_000_000
START_NS = 10**12
KEY = bytes(range(32))


def exchange(traffic: Traffic, driver: Driver, now_ns: int, steps: int = 20) -> tuple[int, list[bytes]]:
    """Carry datagrams both ways for some milliseconds; the time after that and what was sent up."""
    up = []
    for _ in range(steps):
        now_ns += MS
        for _, _, datagram in driver.downlink(now_ns):
            traffic.hear(datagram)
        for datagram in traffic.step(now_ns):
            driver.handle(datagram, now_ns)
            up.append(datagram)
    driver.publish(now_ns)
    return now_ns, up


@pytest.mark.parametrize("length", [0, 1, 55, 63, 64, 65, 128, 1416])
def test_the_tag_is_keyed_blake2s(length: int, seed: int) -> None:
    draw = random.Random(seed + length)
    key, text = draw.randbytes(32), draw.randbytes(length)
    assert keyed_tag(key, text) == hashlib.blake2s(text, key=key).digest()[:16]


def test_a_wrong_key_accepts_nothing(seed: int) -> None:
    traffic = Traffic(100, key=KEY, seed=seed)
    friend, stranger = (Driver(traffic.keys(), key, session_seed=seed) for key in (KEY, bytes(32)))
    _, up = exchange(traffic, friend, START_NS)
    assert friend.statistics()["frames"] > 0
    assert {stranger.handle(datagram, START_NS) for datagram in up} == {Verdict.unauthenticated}
    assert not stranger.samples()["seen"].any()


def test_every_changed_bit_is_noticed(seed: int) -> None:
    traffic = Traffic(10, key=KEY, seed=seed)
    driver = Driver(traffic.keys(), KEY, session_seed=seed)
    now_ns, up = exchange(traffic, driver, START_NS)
    frames = driver.statistics()["frames"]
    for bit in range(8 * len(up[-1])):
        changed = bytearray(up[-1])
        changed[bit // 8] ^= 1 << bit % 8
        assert driver.handle(bytes(changed), now_ns) != Verdict.accepted
    assert driver.statistics()["frames"] == frames


def test_a_restarted_unit_is_believed_and_its_past_is_not(seed: int) -> None:
    before, after = Traffic(100, key=KEY, seed=seed), Traffic(100, key=KEY, seed=seed + 1)
    driver = Driver(before.keys(), KEY, session_seed=seed)
    now_ns, past = exchange(before, driver, START_NS)
    session = driver.session
    now_ns, _ = exchange(after, driver, now_ns + 500 * MS)
    assert driver.session != session
    assert driver.statistics()["sessions"] == 2
    taken = driver.samples()
    now_ns += 500 * MS
    assert Verdict.accepted not in {driver.handle(datagram, now_ns) for datagram in past}
    driver.publish(now_ns)
    for name, values in driver.samples().items():
        np.testing.assert_array_equal(values, taken[name], err_msg=name)


def test_a_new_driver_takes_nothing_that_answered_the_old_one(seed: int) -> None:
    traffic = Traffic(100, key=KEY, seed=seed)
    _, past = exchange(traffic, Driver(traffic.keys(), KEY, session_seed=seed), START_NS)
    driver = Driver(traffic.keys(), KEY, session_seed=seed + 1)
    assert {driver.handle(datagram, START_NS) for datagram in past} == {Verdict.unanswering}


def test_the_bad_is_named() -> None:
    with pytest.raises(InputError, match="5 bytes instead of 32"):
        Driver([1], b"short")
    with pytest.raises(InputError, match="cell id 0 "):
        Driver([0])
    with pytest.raises(InputError, match="cell id 7 of section unit 0 is given twice"):
        Driver([7, 7])
    with pytest.raises(InputError, match=r"host 'no\.\.where' cannot be resolved"):
        Driver([1], bind=("no..where", 0))
    with pytest.raises(InputError, match=r"cannot bind UDP 192\.0\.2\.1 port 1337"):
        Driver([1], bind=("192.0.2.1", 1337))
    with pytest.raises(UnknownNameError, match="unknown operation 'clock_rat': did you mean clock_rate") as unknown:
        Driver([1]).command("clock_rat")
    assert "led" in unknown.value.choices
    with pytest.raises(InputError, match="cell id 0 is not between 1 and 16382"):
        Driver([1]).command("led", cell=0)
