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
