# SPDX-License-Identifier: Apache-2.0
"""How old a sample is, by two clocks that are not set alike: delay is not taken for offset, drift is."""

import pytest

from robotskin.driver import Driver
from robotskin_lab._lab.traffic import Traffic

MS = 1_000_000
START_NS = 10**12
KEY = bytes(range(32))
# A sample's own time, resolved to a sixteenth of a millisecond, batching and the period of this simulation.
AGE_MS = 6.0


def newest_age_ms(seed: int, steps: int, late_ms: int = 0, late_from: int = 0, ppm: float = 0.0) -> float:
    """The age of the newest sample after a run of `steps` ms in which datagrams come late, or the unit's clock slow."""
    traffic = Traffic(20, key=KEY, seed=seed)
    driver = Driver(traffic.keys(), KEY, session_seed=seed)
    on_the_way = []
    for step in range(1, steps + 1):
        now_ns = START_NS + step * MS
        for _, _, datagram in driver.downlink(now_ns):
            traffic.hear(datagram)
        arrival_ns = now_ns + (late_ms * MS if step >= late_from else 0)
        unit_ns = START_NS + round(step * MS * (1 - 1e-6 * ppm))
        on_the_way += [(arrival_ns, datagram) for datagram in traffic.step(unit_ns)]
        while on_the_way and on_the_way[0][0] <= now_ns:
            driver.handle(on_the_way.pop(0)[1], now_ns)
    driver.publish(now_ns)
    return (now_ns - driver.samples()["stamp_ns"].max()) / MS


@pytest.mark.parametrize("late_ms", [30, 300, 3000])
def test_what_is_held_up_on_the_way_stays_as_old_as_it_is(late_ms: int, seed: int) -> None:
    age_ms = newest_age_ms(seed, 9000 + late_ms, late_ms, late_from=500)
    assert 0.9 * late_ms <= age_ms <= late_ms + AGE_MS


@pytest.mark.parametrize("ppm", [-150.0, 0.0, 150.0])
def test_clocks_that_run_apart_are_followed(ppm: float, seed: int) -> None:
    assert 0 <= newest_age_ms(seed, 40_000, ppm=ppm) <= AGE_MS
