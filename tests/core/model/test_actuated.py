# SPDX-License-Identifier: Apache-2.0
"""Which joints have motors: all but those of a floating base; a joint without a stated effort is not unlimited."""

import numpy as np
import pytest

from robotskin import robots
from robotskin.model import RobotModel
from robotskin.tasks import ControlError, QuadraticFusion, QuadraticLimits


def arm(efforts: list[float]) -> RobotModel:
    text = '<robot name="arm"><link name="l0"/>'
    for index, effort in enumerate(efforts):
        text += (
            f'<link name="l{index + 1}"><inertial><mass value="1"/><inertia ixx="0.1" iyy="0.1" izz="0.1" ixy="0" '
            f'ixz="0" iyz="0"/></inertial></link><joint name="j{index}" type="revolute"><parent link="l{index}"/>'
            f'<child link="l{index + 1}"/><axis xyz="0 0 1"/><limit lower="-1" upper="1" velocity="1" '
            f'effort="{effort}"/></joint>'
        )
    return RobotModel(text + "</robot>")


def test_of_a_robot_that_stands_only_the_base_has_no_motors() -> None:
    robot = robots.load("talos_standing").core
    assert [robot.actuated(joint) for joint in range(8)] == [False] * 6 + [True] * 2
    limits = QuadraticLimits.of(robot)
    assert np.all(np.array(limits.torque)[:6] >= 1e5)


def test_a_missing_effort_limit_is_no_unlimited_torque() -> None:
    robot = arm([10.0, 0.0, 5.0])
    assert all(robot.actuated(joint) for joint in range(3))
    limits = QuadraticLimits.of(robot)
    np.testing.assert_array_equal(limits.torque, [10.0, 0.0, 5.0])
    with pytest.raises(ControlError, match=r"torque 0\.0+ of joint 1 must be greater than 0.*effort limit"):
        QuadraticFusion(3, 3, 1, limits)


def test_seven_turning_joints_without_effort_are_no_floating_base() -> None:
    robot = arm([0.0] * 7)
    assert all(robot.actuated(joint) for joint in range(7))
