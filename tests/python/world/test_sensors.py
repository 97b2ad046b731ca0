# SPDX-License-Identifier: Apache-2.0
"""Proximity, temperature and the imperfections of all sensors."""

import numpy as np
import pytest

from robotskin.world import HandSpec, Imperfections


def share_of(distance_m: float) -> float:
    return (0.006 / (0.006 + distance_m)) ** 2


@pytest.mark.parametrize("distance_m", [0.005, 0.02, 0.05, 0.1, 0.15])
def test_proximity_tells_the_gap_to_a_hand(make_body, generator, skin, distance_m):
    world = make_body(imperfections=Imperfections.none())
    cell = int(generator.choice(skin.cells_on("forearm_link")))
    world.approach(cell, distance_m, speed_m_s=0.5)
    world.step(1.5)
    assert world.cell_true_distance()[cell] == pytest.approx(distance_m, abs=2e-4)
    assert world.body.sample(cell, 0)[0] == pytest.approx(65536 * share_of(distance_m), abs=0.006 / distance_m * 4 + 1)


def test_far_hands_are_not_seen_and_touching_ones_fill_the_range(make_body):
    world = make_body(imperfections=Imperfections.none())
    world.step(0.01)
    assert np.isinf(world.cell_true_distance()).all()
    assert world.body.sample(140, 0)[0] == 0
    world.push(140, 5.0)
    world.step(1.0)
    assert world.cell_true_distance()[140] == 0
    assert world.body.sample(140, 0)[0] == 65535


def test_a_touched_cell_warms_towards_the_hand_with_its_lag(make_body):
    world = make_body(hands=(HandSpec(temperature=40.0),))
    world.push(140, 5.0)
    while world.contact_normal_force()[0] == 0:
        world.step(0.001)
    start = world.time_s
    world.step(2.6)
    board, surface = world.cell_true_temperature()[140]
    expected = 40 - 10 * np.exp(-(world.time_s - start) / 2.6)
    assert surface == pytest.approx(expected, abs=0.02)
    assert 30 < board < surface
    assert world.cell_true_temperature()[10] == pytest.approx([30, 30])


def test_noise_is_the_cells_own_and_repeats_with_the_seed(make_body, seed):
    first, again, other = make_body(), make_body(), make_body(seed=seed + 1)
    for world in (first, again, other):
        world.step(0.001)
    draw = lambda world: [[world.body.sample(cell, k * 10**6) for k in range(50)] for cell in (3, 200)]  # noqa: E731
    a, b, c = draw(first), draw(again), draw(other)
    assert a == b
    assert a != c
    assert a[0] != a[1]
    assert np.std(np.array(a)[:, :, 4:7], axis=1).max() == pytest.approx(2.56, rel=0.6)


def test_at_rest_readings_stay_in_the_published_bounds(make_body):
    world = make_body()
    world.step(0.01)
    readings = np.array([world.body.sample(cell, 10**7) for cell in range(260)])
    assert (readings[:, 1:4] <= 5).all()
    assert (readings[:, 0] <= 0.0069 * 65536).all()
    norm = np.linalg.norm(readings[:, 4:7] / 256, axis=1)
    assert (np.abs(norm - 1) < 0.2).all()
    assert (np.abs(readings[:, 8] / 32 - 30) < 1.5).all()


def changes(counts: np.ndarray) -> np.ndarray:
    """(T - 1, N, 9) which readings differ from the one before."""
    return np.diff(counts, axis=0) != 0


def test_a_sensor_holds_its_value_between_its_own_measurements(make_body):
    """Read each millisecond, proximity and acceleration are new at most each 4 ms, at phases spread over the cells."""
    world = make_body()
    world.step(0.001)
    new = changes(np.array([world.body.sample_all(k * 10**6) for k in range(2000)]))
    for channels in (slice(0, 1), slice(4, 7)):
        when, cell = np.nonzero(new[:, :, channels].any(axis=2))
        assert 200 < np.bincount(cell).max() <= 500
        phase = [np.unique(when[cell == one] % 4) for one in np.unique(cell)]
        assert all(len(one) == 1 for one in phase)
        assert (np.bincount(np.concatenate(phase), minlength=4) > 0.15 * len(phase)).all()
    assert new[:, :, 1:4].any(axis=2).sum(axis=0).max() > 600, "forces are converted at each reading"
    assert new[:, :, 7:].any(axis=2).sum(axis=0).max() <= 10, "five temperatures a second"


def test_clock_mode_at_250_hz_finds_a_new_measurement_at_each_reading(make_body):
    world = make_body()
    world.step(0.001)
    counts = np.array([world.body.sample_all(k * 4 * 10**6) for k in range(500)])
    correlation = [np.corrcoef(counts[:-1, cell, 4], counts[1:, cell, 4])[0, 1] for cell in range(0, 260, 10)]
    assert np.abs(np.mean(correlation)) < 0.05


def test_noise_at_rest_makes_hardly_an_event(make_body):
    """With the published second set of thresholds and proximity and force events on, a robot at rest is silent."""
    world = make_body()
    world.step(0.001)
    counts = np.array([world.body.sample_all(k * 10**6) for k in range(1000)])
    spread = counts.max(axis=0) - counts.min(axis=0)
    assert (spread[:, 1:4] < 5).mean() > 0.99
    assert (np.abs(counts[1:, :, 0] - counts[0, :, 0]) >= 7).mean() < 0.001
