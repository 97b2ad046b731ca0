# SPDX-License-Identifier: Apache-2.0
"""The skin state is the newest sample in SI units, and what is not fresh never looks fresh."""

import numpy as np
import pytest

from robotskin.driver import Driver
from robotskin.skin import Health, SkinModel, SkinReader, SkinState
from robotskin_lab._lab.traffic import Traffic

MS = 1_000_000
START_NS = 10**12


def model_of(keys: list[int]) -> SkinModel:
    cells = len(keys)
    return SkinModel(
        link_names=["link"],
        key=np.array(keys, dtype=np.uint32),
        link=np.zeros(cells, dtype=np.int32),
        link_from_cell=np.tile(np.eye(4), (cells, 1, 1)),
        neighbours=np.tile(np.array([-1, 0], dtype=np.int32), (cells, 4, 1)),
        patch=np.zeros(cells, dtype=np.int32),
    )


def streamed(traffic: Traffic, steps: int) -> tuple[Driver, int]:
    driver, now_ns = Driver(traffic.keys(), session_seed=1), START_NS
    for _ in range(steps):
        now_ns += MS
        for _, _, datagram in driver.downlink(now_ns):
            traffic.hear(datagram)
        for datagram in traffic.step(now_ns):
            driver.handle(datagram, now_ns)
    for datagram in traffic.flush(now_ns):
        driver.handle(datagram, now_ns)
    driver.publish(now_ns)
    return driver, now_ns


def test_values_are_the_sent_counts_in_si(seed: int) -> None:
    traffic = Traffic(200, seed=seed)
    driver, now_ns = streamed(traffic, 10)
    state, sent = SkinState(200), traffic.sent()
    SkinReader(driver, model_of(traffic.keys())).read(now_ns, state)
    np.testing.assert_allclose(state.normal_force, sent["force"] * (10 / 1024), rtol=1e-6)
    np.testing.assert_allclose(state.proximity, sent["proximity"] / 65536, rtol=1e-6)
    np.testing.assert_allclose(state.acceleration, sent["acceleration"] * (9.80665 / 256), rtol=1e-6)
    np.testing.assert_allclose(state.temperature, sent["temperature"] / [2, 32], rtol=1e-6)
    assert (np.asarray(state.health) == int(Health.alive)).all()
    assert (np.asarray(state.stamp_ns) <= now_ns).all()


@pytest.mark.parametrize(("event_mode", "bound_ms"), [(False, 20), (True, 300)])
def test_silence_turns_stale_at_the_bound_and_not_before(event_mode: bool, bound_ms: int, seed: int) -> None:
    traffic = Traffic(50, seed=seed, event_mode=event_mode)
    driver, _ = streamed(traffic, 10)
    state, reader = SkinState(50), SkinReader(driver, model_of(traffic.keys()))
    newest_ns = driver.samples()["stamp_ns"]
    for late_ms in range(0, bound_ms + 40, 3):
        now_ns = int(newest_ns.max()) + late_ms * MS
        reader.read(now_ns, state)
        stale = now_ns - newest_ns > bound_ms * MS
        expected = np.where(stale, int(Health.stale), int(Health.alive))
        np.testing.assert_array_equal(np.asarray(state.health), expected)


def test_the_unheard_was_never_seen(seed: int) -> None:
    traffic = Traffic(20, seed=seed)
    keys = [*traffic.keys(), 5000]
    driver = Driver(keys, session_seed=1)
    state = SkinState(21)
    SkinReader(driver, model_of(keys)).read(START_NS, state)
    assert (np.asarray(state.health) == int(Health.never_seen)).all()


def test_a_model_of_other_cells_is_refused() -> None:
    with pytest.raises(ValueError, match="in the model it is 2"):
        SkinReader(Driver([1]), model_of([2]))
    with pytest.raises(ValueError, match="the model has 2 cells, the driver only 1"):
        SkinReader(Driver([1]), model_of([1, 2]))
