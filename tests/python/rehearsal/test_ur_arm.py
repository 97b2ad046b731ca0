# SPDX-License-Identifier: Apache-2.0
"""The arm behind a rehearsed UR controller."""

import numpy as np

from robotskin.rehearsal.ur_arm import UrArm
from robotskin.robots import load
from robotskin.robots.gains import gains_of


def test_an_arm_that_is_put_elsewhere_stays_there_whatever_it_did(seed: int) -> None:
    robot = load("ur5")
    home = np.array(gains_of(robot).home)
    arm = UrArm(robot, home)
    random = np.random.default_rng(seed)
    for ask in (lambda: arm.speed(np.full(6, 0.5), 10.0), lambda: arm.torque(np.zeros(6)), lambda: None):
        ask()
        arm.step(0.1)
        there = home + random.uniform(-0.3, 0.3, 6)
        arm.place(there)
        assert not arm.velocity.any()
        arm.step(0.2)
        assert np.abs(arm.position - there).max() < 1e-3
        assert arm.at_rest
