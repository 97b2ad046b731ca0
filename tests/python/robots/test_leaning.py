# SPDX-License-Identifier: Apache-2.0
"""How far a touch makes a standing robot lean."""

import numpy as np
import pytest

from robotskin import robots
from robotskin.model import RobotDynamics
from robotskin.robots.gains.gain_set import GainSet
from robotskin.robots.gains.leaning import lean_per_newton
from robotskin.skin import STANDARD_GRAVITY_MPS2
from robotskin.tasks import BalanceGains


@pytest.mark.parametrize("direction", [(1.0, 0.0, 0.0), (0.0, 1.0, 0.0)])
def test_it_leans_against_a_push_by_its_height_over_the_weight(
    direction: tuple[float, float, float], seed: int
) -> None:
    robot = robots.load("talos_standing").core
    dynamics = RobotDynamics(robot)
    dynamics.update(GainSet.load("talos_standing").home, np.zeros(robot.joint_count))
    point = np.random.default_rng(seed).uniform([-0.3, -0.3, 0.4], [0.3, 0.3, 1.5], (5, 3))
    lean = lean_per_newton(dynamics, point, np.tile(direction, (5, 1)))
    expected = -BalanceGains().lean * point[:, 2:] / (dynamics.mass * STANDARD_GRAVITY_MPS2) * np.array(direction[:2])
    assert np.allclose(lean, expected)
    above = np.array([[*dynamics.centre_of_mass[:2], 1.0]])
    assert np.allclose(lean_per_newton(dynamics, above, np.array([[0.0, 0.0, -1.0]])), 0.0)
