# SPDX-License-Identifier: Apache-2.0
"""A hand that goes a short way between two postures goes straight, however often it has moved before."""

import numpy as np
import pytest

from robotskin.layout import finished
from robotskin.robots import load
from robotskin.robots.gains import GainSet
from robotskin.teaching.execution import UP_M
from robotskin.teaching.gripper import Gripper
from robotskin.teaching.postures import Postures

MOVES, ASIDE_M = 40, 0.006


@pytest.mark.parametrize("name", ["ur5_gripper", "panda_gripper"])
def test_a_hand_goes_down_straight_after_many_moves(name: str, seed: int) -> None:
    robot = load(name)
    postures = Postures(robot, Gripper(robot, finished(name)), GainSet.load(name).home)
    generator = np.random.default_rng(seed)
    middle = postures.place_of(postures.home) - [0.0, 0.0, 0.25]
    posture, worst_m = postures.home, 0.0
    for _ in range(MOVES):
        place = middle + generator.uniform([-0.05, -0.35, -0.1], [0.05, 0.35, 0.0])
        above = postures.at(place + UP_M, posture)
        posture = postures.at(place, above)
        np.testing.assert_allclose(postures.place_of(posture), place, atol=1e-4)
        for share in (0.25, 0.5, 0.75):
            aside = postures.place_of(above + share * (posture - above)) - place
            worst_m = max(worst_m, float(np.linalg.norm(aside[:2])))
    assert worst_m < ASIDE_M
