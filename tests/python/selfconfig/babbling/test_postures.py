# SPDX-License-Identifier: Apache-2.0
import numpy as np
import pytest

from robotskin.robots import load
from robotskin.robots.free_space import FreeSpace
from robotskin.robots.gains import gains_of
from robotskin.selfconfig.babbling.joint_sine import MotionLimits, plan_joint_sine
from robotskin.selfconfig.babbling.postures import BabblingError, choose_postures

START = np.array([0.0, -1.2, 1.0, -0.8, -1.0, 0.3])
FLOOR = np.array([0.0, 1.0, 1.0, -0.8, -1.0, 0.3])
LINKS = ("shoulder_link", "upper_arm_link", "forearm_link", "wrist_1_link")


@pytest.fixture(scope="module")
def space() -> FreeSpace:
    return FreeSpace(load("ur5"), floor_m=0.0)


def test_what_is_in_the_way_is_named(space: FreeSpace) -> None:
    assert space.why_not(START) is None
    assert "floor" in str(space.why_not(FLOOR))
    assert "elbow_joint" in str(space.why_not(np.array([0.0, -1.2, 5.0, -0.8, -1.0, 0.3])))
    folded = np.array([0.0, -1.2, 3.0, -1.5, -1.5, 0.0])
    assert "come closer" in str(space.why_not(folded))


def test_chosen_postures_are_free_reachable_and_informative(space: FreeSpace, seed: int) -> None:
    plan = choose_postures(space, LINKS, START, np.random.default_rng(seed), candidates=60)
    assert plan.still == ("shoulder_link",), "the first axis is vertical: gravity does not turn in its frame"
    assert all(space.is_free(posture) for posture in plan.postures)
    assert sorted(plan.rest[plan.rest >= 0]) == list(range(8))
    assert np.array_equal(plan.way[0], START)
    assert np.array_equal(plan.way[-1], START)
    for number, posture in zip(plan.rest, plan.way, strict=True):
        assert number < 0 or np.array_equal(plan.postures[number], posture)
    forearm = LINKS.index("forearm_link")
    up = [space.robot.base_from_link(q)[space.robot.link_index("forearm_link"), 2, :3] for q in plan.postures]
    assert np.allclose(plan.up[forearm], up)
    # The three axes before it are one vertical and two horizontal ones: gravity stays in one plane of the forearm.
    spread = np.linalg.eigvalsh(np.cov(plan.up[forearm].T))
    assert spread[0] < 1e-6 < 0.2 < spread[1]
    assert len(np.unique(plan.postures, axis=0)) == 8
    assert np.isinf(plan.rotation_deviation_rad[0])
    assert (plan.rotation_deviation_rad[1:] < np.radians(0.5)).all()


def test_a_start_that_touches_is_refused(space: FreeSpace) -> None:
    with pytest.raises(BabblingError, match=r"start posture: .*floor"):
        choose_postures(space, LINKS, FLOOR, np.random.default_rng(0))


@pytest.mark.parametrize("joint", range(6))
def test_a_swing_keeps_its_bounds_and_comes_back(space: FreeSpace, joint: int) -> None:
    limits = MotionLimits(velocity=0.8, acceleration=6.0, jerk=80.0)
    swing = plan_joint_sine(space, joint, START, limits)
    time_s = np.linspace(0, swing.duration_s, 4001)
    for derivative, bound in ((1, limits.velocity), (2, limits.acceleration), (3, limits.jerk)):
        exact = swing.displacement(time_s, derivative)
        assert np.abs(exact).max() <= bound * 1.001
        numeric = np.gradient(swing.displacement(time_s, derivative - 1), time_s, edge_order=2)
        assert np.allclose(exact, numeric, atol=1e-4 * np.abs(exact).max())
    ends = np.array([0.0, swing.duration_s])
    for derivative in (0, 1, 2):
        assert np.abs(swing.displacement(ends, derivative)).max() < 1e-9
    assert all(space.is_free(posture) for posture in swing.posture(time_s[::200]))
    assert np.array_equal(np.delete(swing.posture(time_s), joint, axis=1)[77], np.delete(START, joint))


def test_a_joint_without_room_is_refused(space: FreeSpace) -> None:
    at_the_limit = START.copy()
    at_the_limit[2] = space.upper[2]
    with pytest.raises(BabblingError, match="elbow_joint cannot swing"):
        plan_joint_sine(space, 2, at_the_limit)


def test_a_humanoid_is_drawn_back_towards_its_start_until_it_is_free(seed: int) -> None:
    robot = load("talos")
    home = gains_of(robot).home
    space = FreeSpace(robot, home=home)
    links = ("torso_2_link", "arm_left_4_link", "leg_right_4_link")
    plan = choose_postures(space, links, home, np.random.default_rng(seed), count=4, candidates=24)
    assert all(space.is_free(posture) for posture in plan.postures)
    assert np.abs(plan.postures - home).max(axis=1).min() > 0.2, "none of them is the start"
    assert "arm_left_4_link" not in plan.still
