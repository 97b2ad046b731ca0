# SPDX-License-Identifier: Apache-2.0
"""Joint impedance: joints move as their own inertia on springs, whatever inertia and friction the user has added."""

import numpy as np
import pytest

from robotskin import robots
from robotskin.control import Behaviour, Controller, Fusion
from robotskin.layout import finished
from robotskin.model import CommandMode, JointCommand, JointState, RobotDynamics
from robotskin.robots.gains import GainSet
from robotskin.skin import Health, SkinState
from robotskin.tasks import ControlError, JointGains, JointImpedanceTask

STIFFNESS, DAMPING = 3.0, 0.05
LARGEST_AGE_S = 0.02


class Rig:
    """The hand by torque, its cycle alone."""

    def __init__(self) -> None:
        self.robot = robots.load("allegro_grasp")
        layout, gains = finished("allegro_grasp"), GainSet.load("allegro_grasp")
        self.n = self.robot.joint_count
        self.home = gains.home
        self.controller = Controller(self.robot.core, layout.skin_model(), gains)
        own = JointGains([STIFFNESS] * self.n, [DAMPING] * self.n)
        self.controller.library.add("mine", lambda library, _: JointImpedanceTask(library.robot, own))
        tasks = self.controller.use(Behaviour("mine", {"mine": 0}, Fusion.weighted_sum, gains="skin_compliance"))
        self.task = tasks["mine"]
        self.controller.request_mode(CommandMode.torque)
        self.controller.request_run(True)
        self.joints, self.command = JointState(self.n), JointCommand(CommandMode.torque, self.n)
        self.joints.position = self.home
        self.skin = SkinState(len(layout))
        self.skin.health[:] = Health.alive.value
        self.now_ns = 10**9

    def tick(self, count: int = 1) -> np.ndarray:
        for _ in range(count):
            self.now_ns += 1_000_000
            self.joints.stamp_ns = self.skin.time_ns = self.now_ns
            self.controller.step(self.joints, self.skin, self.now_ns, self.command)
        return np.array(self.command.value)


def test_the_command_is_the_spring_and_what_carries_the_robot(seed: int) -> None:
    rig = Rig()
    rig.tick(50)
    aside = np.random.default_rng(seed).uniform(-0.05, 0.05, rig.n)
    rig.task.request_reference(rig.home + aside, np.zeros(rig.n))
    command = rig.tick(2)
    dynamics = RobotDynamics(rig.robot.core)
    dynamics.update(rig.home, np.zeros(rig.n))
    np.testing.assert_allclose(command - dynamics.nonlinear_effects, STIFFNESS * aside, atol=1e-9)


def test_a_reference_goes_on_for_a_while_and_then_stands() -> None:
    rig = Rig()
    rig.tick(50)
    velocity = np.full(rig.n, 0.1)
    rig.task.request_reference(rig.home, velocity)
    rig.tick(11)
    np.testing.assert_allclose(rig.task.reference, rig.home + 0.010 * velocity, atol=1e-9)
    rig.tick(200)
    stands = np.array(rig.task.reference)
    assert np.abs(stands - rig.home).max() <= 0.1 * (LARGEST_AGE_S + 0.0011)
    rig.tick(50)
    np.testing.assert_array_equal(rig.task.reference, stands)


def test_a_joint_near_its_end_is_pushed_back() -> None:
    rig = Rig()
    rig.tick(50)
    position = np.array(rig.home)
    position[3] = rig.robot.upper[3] - 0.045
    rig.joints.position = position
    rig.task.request_reference(position, np.zeros(rig.n))
    dynamics = RobotDynamics(rig.robot.core)
    dynamics.update(position, np.zeros(rig.n))
    push = rig.tick(2) - dynamics.nonlinear_effects
    assert push[3] == pytest.approx(-10 * STIFFNESS * 0.015, rel=1e-6)
    assert np.abs(np.delete(push, 3)).max() < 1e-6


def test_what_does_not_fit_is_refused_by_name() -> None:
    robot = robots.load("allegro_grasp").core
    n = robot.joint_count
    with pytest.raises(ControlError, match="joint impedance task: stiffness has 3 values"):
        JointImpedanceTask(robot, JointGains([1.0] * 3, [1.0] * n))
    task = JointImpedanceTask(robot, JointGains([1.0] * n, [1.0] * n))
    far = np.zeros(n)
    far[2] = 9.0
    with pytest.raises(ControlError, match=r"reference 9\.0+ of joint 2"):
        task.request_reference(far, np.zeros(n))
    with pytest.raises(ControlError, match="velocity of joint 1 is not finite"):
        task.request_reference(np.array(robot.lower), np.where(np.arange(n) == 1, np.nan, 0.0))
