# SPDX-License-Identifier: Apache-2.0
"""Levers of cells are the derivatives of their places by the joints."""

import numpy as np

from robotskin import robots
from robotskin.layout import finished
from robotskin.model import RobotDynamics
from robotskin.robots.gains.cell_levers import cell_levers

STEP_RAD = 1e-6


def test_jacobians_are_the_change_of_place_with_the_joints(seed: int) -> None:
    robot, skin = robots.load("ur5").core, finished("ur5").skin_model()
    dynamics = RobotDynamics(robot)
    posture = np.random.default_rng(seed).uniform(-2, 2, robot.joint_count)

    def at(joints: np.ndarray):
        dynamics.update(joints, np.zeros(robot.joint_count))
        return cell_levers(robot, skin, dynamics)

    here = at(posture)
    for joint in range(robot.joint_count):
        step = STEP_RAD * np.eye(robot.joint_count)[joint]
        change = (at(posture + step).point - at(posture - step).point) / (2 * STEP_RAD)
        assert np.allclose(change, here.jacobian[:, :, joint], atol=1e-7)
    assert np.allclose(np.linalg.norm(here.inward, axis=1), 1, atol=1e-5)
    assert np.allclose(here.torque, [inward @ moved for inward, moved in zip(here.inward, here.jacobian, strict=True)])
