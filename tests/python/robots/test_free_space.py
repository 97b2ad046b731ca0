# SPDX-License-Identifier: Apache-2.0
import numpy as np
import pytest

from robotskin.configuring.configured import home_posture
from robotskin.robots import load
from robotskin.robots.free_space import FreeSpace
from robotskin.robots.gains import gains_of


@pytest.mark.parametrize("name", ["panda", "ur10", "xarm7", "ur5"])
def test_an_exploration_begins_where_the_robot_may_stand(name: str) -> None:
    """With gains or without; the neutral posture of a Panda lies at a limit, that of a UR10 in itself."""
    robot = load(name)
    space = FreeSpace(robot)
    assert space.why_not(home_posture(robot, space)) is None


def test_the_nearest_free_posture_of_a_free_one_is_itself(seed: int) -> None:
    space = FreeSpace(load("ur5"))
    random = np.random.default_rng(seed)
    free = next(q for q in random.uniform(-1.5, 1.5, (100, 6)) if space.is_free(q))
    assert np.array_equal(space.nearest_free(free), free)


def test_links_that_are_built_close_need_only_not_touch() -> None:
    """A G1's elbow lies 2 cm from the pitch link of its wrist, in every posture."""
    robot = load("g1")
    assert FreeSpace(robot).why_not(home_posture(robot)) is None
    assert FreeSpace(robot, margin_m=0.2).why_not(home_posture(robot)) is not None


def test_links_that_are_close_at_home_need_only_not_touch() -> None:
    """The thighs of Talos stand less than 2 cm apart."""
    robot = load("talos")
    home = gains_of(robot).home
    assert "come closer" in str(FreeSpace(robot).why_not(home))
    space = FreeSpace(robot, home=home)
    assert space.why_not(home) is None
    crossed = home.copy()
    crossed[robot.joint_index("leg_left_2_joint")] -= 0.2
    assert "leg_right" in str(space.why_not(crossed))
