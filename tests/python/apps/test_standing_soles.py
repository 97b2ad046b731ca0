# SPDX-License-Identifier: Apache-2.0
"""A sole on an edge without cells bears what lacks of the weight, where its tilt says; cells correct the tilt."""

import numpy as np
import pytest

from robotskin import robots
from robotskin.apps.balance.foot_tilts import FootTilts
from robotskin.apps.balance.standing_soles import SoleFoam, StandingSoles
from robotskin.model import PortSensors, SensorPlace, SensorReadings
from robotskin.robots.gains import GainSet

HALF = np.array([0.1, 0.06])
FOAM = SoleFoam((0.1, 0.06), 4e5, 0.0)
WEIGHT_N, PERIOD_S = 900.0, 0.008
SURE, UNFELT = 0.01, 1.0
NAME = "talos_standing"
ROBOT, HOME = robots.load(NAME), np.array(GainSet.load(NAME).home)
assert ROBOT.standing is not None
UNIT = SensorPlace("imu", ROBOT.standing.imu_link)


def tilted(roll: float, pitch: float) -> tuple[StandingSoles, np.ndarray]:
    """Soles of a robot whose right foot is turned by so many rad from home, and its joints (n,)."""
    joints = HOME.copy()
    joints[ROBOT.joint_index("leg_right_6_joint")] += roll
    joints[ROBOT.joint_index("leg_right_5_joint")] += pitch
    unit = SensorReadings(PortSensors(imus=[UNIT])).imus[0]
    unit.up_from_sensor = ROBOT.base_from_link(joints)[ROBOT.link_index(UNIT.link)][:3, :3].ravel().tolist()
    unit.angular_velocity = (0.0, 0.0, 0.0)
    tilts = FootTilts(ROBOT, UNIT)
    tilts.hear(unit, PERIOD_S)
    return StandingSoles(FOAM, tilts, WEIGHT_N), joints


def told_by(soles: StandingSoles, felt: np.ndarray, unsure: list[float], joints: np.ndarray) -> np.ndarray:
    """Of soles whose cells are so unsure, along and across, and may miss as much."""
    return soles.loads(felt, np.array([[one, one] for one in unsure]), np.array(unsure), joints, PERIOD_S)


def centres(loads: np.ndarray) -> np.ndarray:
    return loads[:, 1:] / loads[:, :1]


@pytest.fixture
def generator(seed: int) -> np.random.Generator:
    return np.random.default_rng([seed, 71])


def test_foam_presses_the_more_beside_the_middle_the_more_a_sole_is_tilted(generator: np.random.Generator) -> None:
    assert FOAM.centre(np.zeros(2), 400.0) == pytest.approx([0.0, 0.0])
    for _ in range(20):
        tilt, load = generator.uniform(-1e-3, 1e-3, 2) * (3.0, 6.0), generator.uniform(100.0, 800.0)
        centre = FOAM.centre(tilt, load)
        assert (np.abs(centre) <= HALF + 1e-12).all()
        assert (centre * tilt <= 0).all(), "it presses where it is low"
        while_flat = -FOAM.newton_per_m * HALF**2 * tilt / load
        if np.abs(while_flat / HALF).sum() < 1:
            assert centre == pytest.approx(while_flat)
            assert FOAM.slope(tilt, load, np.full(2, 1e-7)) == pytest.approx(
                np.diag(-FOAM.newton_per_m * HALF**2 / load), abs=1e-6
            )
    assert FOAM.centre(np.array([0.0, 0.02]), 400.0) == pytest.approx([0.0, -0.06])
    assert FOAM.centre(np.array([-0.02, 0.02]), 100.0) == pytest.approx([0.1, -0.06])


@pytest.mark.parametrize(("roll", "pitch", "edge"), [(0.03, 0.0, (1, -1)), (-0.03, 0.0, (1, 1)), (0.0, 0.03, (0, 1))])
def test_a_sole_that_feels_nothing_stands_on_its_lowest_edge(roll: float, pitch: float, edge: tuple[int, int]) -> None:
    soles, joints = tilted(roll, pitch)
    felt = np.array([[600.0, 6.0, 3.0], [0.0, 0.0, 0.0]])
    told = told_by(soles, felt, [SURE, UNFELT], joints)
    axis, sign = edge
    assert told[0, 0] == pytest.approx(600.0, rel=0.02)
    assert told[:, 0].sum() == pytest.approx(WEIGHT_N)
    assert centres(told)[1, axis] == pytest.approx(sign * HALF[axis])
    assert centres(told)[0] == pytest.approx([0.01, 0.005], abs=2e-3)


def test_soles_that_are_sure_are_believed_whatever_the_tilt_says() -> None:
    soles, joints = tilted(0.004, -0.002)
    felt = np.array([[500.0, 10.0, -4.0], [400.0, -8.0, 6.0]])
    for _ in range(50):
        told = told_by(soles, felt, [SURE, SURE], joints)
    assert told == pytest.approx(felt, rel=0.05)


def test_what_the_cells_miss_is_borne_where_they_may_miss_it() -> None:
    """A foot in the air whose cells reach its edges is given nothing of what sensors at their end do not feel. What is
    told beyond the weight is taken from those, too."""
    soles, joints = tilted(0.0, 0.0)
    felt = np.array([[600.0, 0.0, 0.0], [0.0, 0.0, 0.0]])
    places = np.array([[SURE, SURE], [UNFELT, UNFELT]])
    for _ in range(10):
        told = soles.loads(felt, places, np.array([0.5, 0.0]), joints, PERIOD_S)
    assert told[:, 0] == pytest.approx([WEIGHT_N, 0.0], abs=0.1)
    beyond = np.array([[1500.0, 0.0, 0.0], [300.0, 0.0, 0.0]])
    told = soles.loads(beyond, np.array([[SURE, SURE]] * 2), np.array([0.5, 0.0]), joints, PERIOD_S)
    assert told[:, 0] == pytest.approx([WEIGHT_N - 300.0, 300.0], abs=0.1)


def test_what_cells_told_of_a_tilt_counts_when_they_feel_nothing() -> None:
    soles, joints = tilted(0.004, 0.0)  # by its encoders on its right edge, but it stands flat
    felt = np.array([[450.0, 0.0, 0.0], [450.0, 0.0, 0.0]])
    assert centres(told_by(soles, felt * [[1], [0]], [SURE, UNFELT], joints))[1, 1] < -0.01
    for _ in range(200):
        told_by(soles, felt, [SURE, SURE], joints)
    told = told_by(soles, felt * [[1], [0]], [SURE, UNFELT], joints)
    assert centres(told)[1] == pytest.approx([0.0, 0.0], abs=3e-3)


def test_for_a_moment_both_soles_may_feel_nothing_but_a_robot_that_hangs_bears_nothing() -> None:
    soles, joints = tilted(0.0, 0.0)
    nothing, unfelt = np.zeros((2, 3)), [UNFELT, UNFELT]
    assert told_by(soles, nothing, unfelt, joints) == pytest.approx(nothing), "it was never put down"
    told_by(soles, np.array([[600.0, 0.0, 0.0], [300.0, 0.0, 0.0]]), [SURE, SURE], joints)
    told = told_by(soles, nothing, unfelt, joints)
    assert told[:, 0] == pytest.approx([600.0, 300.0])
    assert centres(told)[:, 1] == pytest.approx([0.0, 0.0], abs=3e-3)
    for _ in range(100):
        told = told_by(soles, nothing, unfelt, joints)
    assert told == pytest.approx(nothing)


def test_without_an_inertial_unit_only_what_cells_feel_is_told() -> None:
    soles = StandingSoles(FOAM, FootTilts(ROBOT, UNIT), WEIGHT_N)
    felt = np.array([[500.0, 10.0, -4.0], [0.0, 0.0, 0.0]])
    assert told_by(soles, felt, [SURE, UNFELT], HOME) == pytest.approx(felt)
