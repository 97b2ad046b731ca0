# SPDX-License-Identifier: Apache-2.0
"""The load that cells beside an insole tell: also on an edge, and beside a sensor that is at its end."""

import numpy as np
import pytest

from robotskin.apps.balance.soles import SoleCalibration, SolePressure

HALF_M = (0.1, 0.06)
NOISE_N = 0.005


def tiled() -> np.ndarray:
    """(96, 2) metres: sensors all over the sole."""
    x, y = np.linspace(-0.9, 0.9, 12) * HALF_M[0], np.linspace(-0.85, 0.85, 8) * HALF_M[1]
    return np.stack(np.meshgrid(x, y, indexing="ij"), axis=-1).reshape(-1, 2)


class Sole:
    """Sensors whose shares of the load are drawn, and what they feel."""

    def __init__(self, generator: np.random.Generator, range_n: float = 1e3) -> None:
        self.draw, self.places, self.range_n = generator, tiled(), range_n
        self.share = generator.uniform(0.5, 1.5, len(self.places)) * 1e-3
        self.pressure = SolePressure(HALF_M)
        self.calibration = SoleCalibration(self.places, HALF_M, NOISE_N, range_n)
        loads, centres = generator.uniform(200, 800, 200), generator.uniform(-0.95, 0.95, (200, 2)) * HALF_M
        felt = np.array([self.feel(load, centre) for load, centre in zip(loads, centres, strict=True)])
        self.calibration.learn(felt, loads, centres)
        loads_and_moments = np.column_stack([loads, loads[:, None] * centres])
        self.linear = np.linalg.lstsq(felt, loads_and_moments, rcond=None)[0]

    def feel(self, load_n: float, centre_m: np.ndarray) -> np.ndarray:
        felt = self.share * load_n * self.pressure.at(self.places, self.pressure.plane(centre_m))
        return np.clip(felt + self.draw.normal(0.0, NOISE_N, len(felt)), 0.0, self.range_n)


@pytest.fixture
def generator(seed: int) -> np.random.Generator:
    return np.random.default_rng([seed, 61])


def test_a_plane_bears_its_load_where_it_presses(generator: np.random.Generator) -> None:
    pressure = SolePressure(HALF_M)
    for centre in generator.uniform(-0.95, 0.95, (50, 2)) * HALF_M:
        assert pressure.load(pressure.plane(centre)) == pytest.approx([1.0, *centre], abs=3e-3)
    assert pressure.at(np.zeros((1, 2)), pressure.plane(np.zeros(2))) == pytest.approx([1.0])


def test_a_foot_that_stands_on_an_edge_is_told_where_a_linear_map_fails(generator: np.random.Generator) -> None:
    sole = Sole(generator)
    off, linearly = [], []
    for _ in range(100):
        centre = np.array([generator.choice([-1, 1]) * 0.9, generator.uniform(-0.5, 0.5)]) * HALF_M
        felt = sole.feel(500.0, centre)
        load, *moments = sole.calibration.load(felt)
        assert load == pytest.approx(500.0, rel=0.05)
        off.append(np.linalg.norm(np.array(moments) / load - centre))
        load, *moments = felt @ sole.linear
        linearly.append(np.linalg.norm(np.array(moments) / load - centre))
    assert max(off) < 3e-3 < 2 * max(off) + 3e-3 < max(linearly)


def test_sensors_at_their_end_say_at_least_so_much(generator: np.random.Generator) -> None:
    sole = Sole(generator, range_n=1.5)
    centre = np.array([0.7, 0.3]) * HALF_M
    felt = sole.feel(700.0, centre)
    assert (felt >= 1.5).sum() > 3
    load, *moments = sole.calibration.load(felt)
    assert load == pytest.approx(700.0, rel=0.03)
    assert np.array(moments) / load == pytest.approx(centre, abs=2e-3)


def test_a_foot_in_the_air_bears_nothing(generator: np.random.Generator) -> None:
    sole = Sole(generator)
    assert sole.calibration.load(sole.feel(0.0, np.zeros(2)))[0] == pytest.approx(0.0, abs=5.0)


def test_less_is_sure_where_a_foot_stands_beside_its_sensors(generator: np.random.Generator) -> None:
    sole = Sole(generator)
    middle, edge, corner = (sole.feel(500.0, np.array(at) * HALF_M) for at in ((0, 0), (0.9, 0), (0.95, 0.95)))
    unsure = [sole.calibration.unsure(felt) for felt in (middle, edge, corner, np.zeros(len(sole.places)))]
    assert 0 < unsure[0].max() < unsure[1].max() < unsure[2].max() <= unsure[3].max() == 1.0
    assert unsure[1][1] < 0.3 * unsure[1][0], "along an edge many sensors feel it"


def test_a_load_may_be_missed_by_sensors_at_their_end_and_by_a_rim_without_sensors(
    generator: np.random.Generator,
) -> None:
    """So a foot in the air is in doubt where its sensors leave a rim, and hardly where they cover the sole."""
    covered, ended = Sole(generator), Sole(generator, range_n=1.5)
    nothing = np.zeros(len(covered.places))
    rim = SoleCalibration(0.5 * covered.places, HALF_M, NOISE_N, 1e3)
    assert rim.doubt(nothing) > 3 * covered.calibration.doubt(nothing)
    pressed = ended.feel(700.0, np.array([0.7, 0.3]) * HALF_M)
    assert ended.calibration.doubt(pressed) > covered.calibration.doubt(nothing)
    assert covered.calibration.doubt(pressed) < 0.1 * covered.calibration.doubt(nothing)
