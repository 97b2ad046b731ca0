# SPDX-License-Identifier: Apache-2.0
"""The tilt of a sole follows from encoders and inertial unit, and what is constant in its error is learnt."""

import numpy as np
import pytest

from robotskin import robots
from robotskin.apps.balance.foot_tilts import FootTilts
from robotskin.model import ImuReading, PortSensors, SensorPlace, SensorReadings
from robotskin.robots.gains import GainSet

NAME = "talos_standing"
ROBOT = robots.load(NAME)
assert ROBOT.standing is not None
UNIT = SensorPlace("imu", ROBOT.standing.imu_link)
FEET = [foot.link for foot in ROBOT.standing.feet]
PERIOD_S = 0.008


def postured(generator: np.random.Generator, lean_rad: float = 0.1) -> np.ndarray:
    """(n,) rad: near home, and leaning."""
    joints = np.array(GainSet.load(NAME).home)
    joints[4:] += generator.uniform(-lean_rad, lean_rad, len(joints) - 4)
    return joints


def turn(joints: np.ndarray, link: str) -> np.ndarray:
    return ROBOT.base_from_link(joints)[ROBOT.link_index(link)][:3, :3]


def unheard() -> ImuReading:
    return SensorReadings(PortSensors(imus=[UNIT])).imus[0]


def reading(joints: np.ndarray) -> ImuReading:
    """Of a base that rests."""
    unit = unheard()
    unit.up_from_sensor, unit.angular_velocity = turn(joints, UNIT.link).ravel().tolist(), (0.0, 0.0, 0.0)
    return unit


def true_tilts(joints: np.ndarray) -> np.ndarray:
    return np.array([turn(joints, foot)[2, :2] for foot in FEET])


@pytest.fixture
def generator(seed: int) -> np.random.Generator:
    return np.random.default_rng([seed, 67])


def test_tilts_are_of_the_level_ground_wherever_the_base_is(generator: np.random.Generator) -> None:
    for _ in range(5):
        joints, tilts = postured(generator), FootTilts(ROBOT, UNIT)
        tilts.hear(reading(joints), PERIOD_S)
        measured = joints.copy()
        measured[:6] = np.nan  # no encoder tells where the base is
        tilts.update(measured, PERIOD_S)
        assert tilts.tilts() == pytest.approx(true_tilts(joints), abs=1e-9)


def test_nothing_is_told_before_unit_and_encoders_are_heard(generator: np.random.Generator) -> None:
    joints, tilts = postured(generator), FootTilts(ROBOT, UNIT)
    tilts.update(joints, PERIOD_S)
    tilts.hear(unheard(), PERIOD_S)  # a unit that measures nothing says NaN
    tilts.update(joints, PERIOD_S)
    assert tilts.tilts() is None
    tilts.hear(reading(joints), PERIOD_S)
    tilts.update(np.full(len(joints), np.nan), PERIOD_S)
    assert tilts.tilts() is None


def test_a_base_that_turns_is_followed_though_the_unit_says_so_late(generator: np.random.Generator) -> None:
    joints, tilts = postured(generator, 0.0), FootTilts(ROBOT, UNIT)
    tilts.hear(reading(joints), PERIOD_S)
    tilts.update(joints, PERIOD_S)
    rolling = joints.copy()
    for _ in range(100):
        rolling[5] += 0.05 * PERIOD_S  # the base's roll, with its own x axis
        late = reading(joints)
        late.angular_velocity = tuple(turn(rolling, UNIT.link).T @ (turn(rolling, "base_link") @ (0.05, 0.0, 0.0)))
        tilts.hear(late, PERIOD_S)
        tilts.update(joints, PERIOD_S)
    moved = true_tilts(rolling) - true_tilts(joints)
    assert tilts.tilts() == pytest.approx(true_tilts(rolling), abs=0.05 * np.abs(moved).max())
    # As they turn now, so much later.
    ahead = tilts.tilts(0.1) - tilts.tilts()
    assert ahead == pytest.approx(0.1 * moved / (100 * PERIOD_S), abs=0.1 * np.abs(0.1 * moved).max() + 1e-5)


def test_a_foot_that_tells_its_tilt_corrects_itself_and_the_unit_of_the_other(generator: np.random.Generator) -> None:
    joints, tilts = postured(generator), FootTilts(ROBOT, UNIT)
    tilts.hear(reading(joints), PERIOD_S)
    tilts.update(joints, PERIOD_S)
    before, off, slope = tilts.unsure, np.array([6e-3, -4e-3]), np.diag([-3.0, -2.0])
    for _ in range(200):
        told = slope @ (true_tilts(joints)[0] + off)
        tilts.learn(0, told - slope @ tilts.tilts()[0], slope, np.full(2, 0.01))
    moved = tilts.tilts() - true_tilts(joints)
    assert moved[0] == pytest.approx(off, rel=0.05)
    assert 0.2 < moved[1, 0] / moved[0, 0] < 0.8
    assert (tilts.unsure[0] < 0.1 * before[0]).all()
    assert (tilts.unsure[1] < before[1]).all()
    assert (tilts.unsure[1] > 0.3 * before[1]).all()
