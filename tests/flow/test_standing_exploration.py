# SPDX-License-Identifier: Apache-2.0
"""A robot on its feet explores its skin with arms, torso and head, and does not fall."""

import dataclasses

import numpy as np
import pytest

from robotskin.configuring.configured import babble
from robotskin.configuring.exploration import ExplorationError
from robotskin.configuring.standing_exploration import BalancedSpace, StandingExploration, leg_joints
from robotskin.layout import finished
from robotskin.robots import load
from robotskin.robots.gains import gains_of
from robotskin.robots.standing import BASE_JOINTS
from robotskin.selfconfig.babbling.joint_sine import plan_joint_sine
from robotskin.selfconfig.babbling.postures import BabblingError

NAME = "talos_standing"
BASE = len(BASE_JOINTS)


def test_legs_are_what_carries_the_feet() -> None:
    names = load(NAME).joint_names
    assert [names[joint] for joint in leg_joints(load(NAME))] == [name for name in names if name.startswith("leg_")]


def test_what_leans_too_far_is_not_free_and_held_joints_stay() -> None:
    robot, home = load("talos"), np.array(gains_of(load(NAME)).home)[BASE:]
    torso = robot.joint_index("torso_2_joint")
    space = BalancedSpace(robot, home, [torso], 0.01)
    assert space.is_free(home)
    leaning = home.copy()
    leaning[torso] = space.upper[torso]
    assert "the centre of mass is" in (space.why_not(leaning) or "")
    other = home.copy()
    other[robot.joint_index("head_2_joint")] += 0.1
    assert "head_2_joint" in (space.why_not(other) or "")


@pytest.mark.timeout(300)
def test_arms_move_and_swing_while_the_legs_keep_the_robot_upright(seed: int) -> None:
    robot = load(NAME)
    home = np.array(gains_of(robot).home)
    exploration = StandingExploration(robot, finished(NAME), seed)
    lowest = [np.inf]
    exploration.moved = lambda *_told: lowest.append(exploration.world.joint_positions()[2])
    goal = home.copy()
    shoulders = [robot.joint_index(f"arm_{side}_1_joint") for side in ("left", "right")]
    goal[shoulders] += (-0.3, 0.3)
    exploration.move_to(goal)
    reached = exploration.world.joint_positions()
    assert reached[shoulders] == pytest.approx(goal[shoulders], abs=0.05)

    joint = robot.joint_index("arm_left_4_joint")
    space = BalancedSpace(load("talos"), goal[BASE:], [joint - BASE])
    mounted = plan_joint_sine(space, joint - BASE, goal[BASE:], cycles=1)
    felt = exploration.swing(dataclasses.replace(mounted, joint=joint, centre=goal))
    assert felt.swing.amplitude == pytest.approx(mounted.amplitude, rel=0.15)
    assert felt.posture is not None
    assert felt.posture[:, joint] == pytest.approx(felt.swing.posture(felt.time_s)[:, joint], abs=0.01)
    assert 1e-5 < np.ptp(felt.posture[:, :3], axis=0).max() < 0.02  # the base answers
    exploration.stop()
    assert min(lowest) > 0.95 * home[2]
    assert np.abs(exploration.world.joint_positions()[3:BASE]).max() < np.radians(10)


def test_where_balance_stops_nothing_moves_on(seed: int) -> None:
    robot = load(NAME)
    exploration = StandingExploration(robot, finished(NAME), seed)
    exploration._loop.request_run(False)
    with pytest.raises(ExplorationError, match="balance stopped: stopped on request"):
        exploration.settle(0.1)
    exploration.stop()
    assert exploration.world.joint_positions()[2] > 0.95 * gains_of(robot).home[2]


def test_what_only_one_exploration_has_is_refused_before_anything_moves() -> None:
    with pytest.raises(BabblingError, match="explores twice"):
        babble(load(NAME), finished(NAME), floor_m=0.0)
