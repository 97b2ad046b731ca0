# SPDX-License-Identifier: Apache-2.0
"""Goals of several limbs at once: each limb does what is asked of it, the others hold, and the skin gives way."""

import numpy as np
import pytest
from following_robot import FollowingRobot

from robotskin.control import CartesianGoal, Controller, ForceGoal, Goal, JointGoal, LimbGoals
from robotskin.cycle import SafetyState, SkinSource
from robotskin.errors import InputError, UnknownNameError
from robotskin.model import ModelError, RobotDynamics
from robotskin.selfconfig.map.sensory_motor_map import SensoryMotorMap
from robotskin.tasks import ControlError, Fusion

ARM_JOINTS = 6
LEFT, RIGHT = slice(3, 9), slice(9, 15)


class Rig(FollowingRobot):
    """A mobile robot with two arms, which has run for a moment."""

    def __init__(self, fusion: Fusion | None = None) -> None:
        super().__init__("dual_arm", fusion=fusion)
        self.dynamics = RobotDynamics(self.robot)
        self.run(0.1)

    @property
    def position(self) -> np.ndarray:
        return np.array(self.joints.position)

    def pose(self, link: str) -> np.ndarray:
        self.dynamics.update(self.position, np.zeros(15))
        return np.array(self.dynamics.base_from_link(self.robot.link_index(link)))

    def cell_on(self, link: str, number: int = 0) -> int:
        return int(np.flatnonzero(self.skin_model.link == self.skin_model.link_names.index(link))[number])

    def cell_pose(self, cell: int) -> np.ndarray:
        name = self.skin_model.link_names[self.skin_model.link[cell]]
        return self.pose(name) @ self.skin_model.link_from_cell[cell]


@pytest.fixture
def rig() -> Rig:
    return Rig()


def test_one_arm_goes_to_a_pose_as_the_other_goes_to_a_posture(rig, seed: int) -> None:
    generator = np.random.default_rng(seed)
    pose = rig.pose("left_ee_link")
    pose[:3, 3] += generator.uniform(-0.06, 0.06, 3)
    posture = rig.gains.home[RIGHT] + generator.uniform(-0.3, 0.3, ARM_JOINTS)
    rig.controller.go(LimbGoals({"left_arm": CartesianGoal(pose), "right_arm": JointGoal(posture)}))
    assert rig.run(8.0) == SafetyState.running
    np.testing.assert_allclose(rig.pose("left_ee_link")[:3, 3], pose[:3, 3], atol=3e-3)
    np.testing.assert_allclose(rig.position[RIGHT], posture, atol=2e-3)
    np.testing.assert_allclose(rig.position[:3], rig.gains.home[:3], atol=5e-3)  # the base has no goal, and stays


def test_a_limb_that_moves_gives_way_to_touch(rig) -> None:
    rig.controller.go(LimbGoals({"left_arm": JointGoal(rig.gains.home[LEFT])}))
    rig.run(0.5)
    for link, limb, other in (("left_forearm_link", LEFT, RIGHT), ("right_forearm_link", RIGHT, LEFT)):
        rig.skin.normal_force[rig.cell_on(link, 9)] = 2.0
        rig.run(1.5)
        moved = np.abs(rig.position - rig.gains.home)
        assert moved[limb].max() > 0.004, link
        assert moved[other].max() < 0.1 * moved[limb].max(), link
        rig.skin.normal_force[:] = 0
        rig.run(3.0)


def test_one_arm_presses_as_the_other_reaches(rig) -> None:
    """Against a wall that yields like a spring; the arm that presses does not give way to what it presses."""
    link = "left_wrist_2_link"
    cell = rig.cell_on(link, 6)
    start, normal = rig.cell_pose(cell)[:3, 3], rig.cell_pose(cell)[:3, 2]
    posture = rig.gains.home[RIGHT] + 0.2
    pressing = ForceGoal(force_n=8.0 * normal, link=link)
    rig.controller.go(LimbGoals({"left_arm": pressing, "right_arm": JointGoal(posture)}))
    for _ in range(6_000):
        pressed = max(20_000 * float((rig.cell_pose(cell)[:3, 3] - start) @ normal), 0.0)
        rig.skin.normal_force[cell] = pressed / 3
        state = rig.run(0.001)
    assert state == SafetyState.running
    assert pressed == pytest.approx(8.0, abs=0.5)
    np.testing.assert_allclose(rig.position[RIGHT], posture, atol=5e-3)


def test_one_arm_is_led_as_the_other_holds(rig) -> None:
    rig.controller.go(LimbGoals({"left_arm": ForceGoal(), "right_arm": JointGoal(rig.gains.home[RIGHT])}))
    rig.run(0.5)
    rig.skin.normal_force[rig.cell_on("left_forearm_link", 9)] = 2.0
    rig.run(1.0)
    rig.skin.normal_force[:] = 0
    rig.run(1.0)
    left = rig.position[LEFT]
    assert np.abs(left - rig.gains.home[LEFT]).max() > 0.01
    rig.run(1.0)
    np.testing.assert_allclose(rig.position[LEFT], left, atol=1e-3)
    np.testing.assert_allclose(rig.position[RIGHT], rig.gains.home[RIGHT], atol=5e-3)


def test_a_led_hand_moves_its_limb_alone(rig) -> None:
    rig.controller.go(LimbGoals({"right_arm": ForceGoal(hand=True)}))
    rig.run(0.5)
    before = rig.pose("right_wrist_3_link")[:3, 3]
    rig.skin.normal_force[rig.cell_on("right_forearm_link", 9)] = 3.0
    rig.run(1.0)
    assert np.linalg.norm(rig.pose("right_wrist_3_link")[:3, 3] - before) > 0.005
    np.testing.assert_allclose(rig.position[LEFT], rig.gains.home[LEFT], atol=5e-3)


def test_a_goal_that_follows_a_goal_takes_over_without_a_jump(rig) -> None:
    pose = rig.pose("left_ee_link")
    rig.controller.go(LimbGoals({"left_arm": CartesianGoal(pose), "right_arm": ForceGoal()}))
    rig.run(0.5)
    before = np.array(rig.joints.velocity)
    rig.controller.go(LimbGoals({"right_arm": CartesianGoal(rig.pose("right_wrist_3_link")), "left_arm": ForceGoal()}))
    rig.run(0.002)
    np.testing.assert_allclose(rig.joints.velocity, before, atol=2e-3)
    assert rig.run(1.0) == SafetyState.running


@pytest.mark.parametrize(
    ("goals", "message"),
    [
        ({}, "no limb has a goal: .*base, left_arm, right_arm"),
        ({"left": ForceGoal()}, "limb of dual_arm 'left': did you mean left_arm"),
        ({"left_arm": JointGoal(np.zeros(7))}, "limb left_arm has 7 values, its joints are left_shoulder_pan_joint"),
        ({"left_arm": JointGoal(np.full(6, 99.0))}, "reference 99"),
        ({"left_arm": CartesianGoal(np.eye(3))}, r"shape \(3, 3\)"),
        ({"left_arm": CartesianGoal(np.eye(4), link="right_ee_link")}, "link of limb left_arm 'right_ee_link'"),
        ({"left_arm": ForceGoal(force_n=(5, 0, 0), link="elbow")}, "elbow"),
        ({"left_arm": ForceGoal(force_n=(5, 0, 0), link="left_ee_link")}, "no cell on or beyond left_ee_link"),
        ({"left_arm": "up"}, "no goal"),
    ],
)
def test_goals_that_a_limb_cannot_have_are_refused_and_change_nothing(
    rig, goals: dict[str, Goal], message: str
) -> None:
    before = rig.controller.behaviour
    with pytest.raises((InputError, UnknownNameError, ControlError, ModelError), match=message):
        rig.controller.go(LimbGoals(goals))
    assert rig.controller.behaviour == before
    assert rig.run(0.1) == SafetyState.running


def test_limbs_keep_their_levels_whatever_fusion_other_behaviours_take() -> None:
    rig = Rig(Fusion.weighted_sum)
    rig.controller.go(LimbGoals({"left_arm": ForceGoal()}))
    assert rig.controller.fusion is Fusion.null_space


def test_what_the_skin_sums_itself_is_no_part_of_a_limbs_reaction(rig) -> None:
    rig.controller.request_skin_source(SkinSource.skin)
    rig.controller.go(LimbGoals({"left_arm": ForceGoal(force_n=(1, 0, 0), link="left_wrist_2_link")}))
    with pytest.raises(InputError, match="limb_goals sums the cells' forces on the host"):
        rig.controller.request_skin_source(SkinSource.skin)


def test_a_limb_presses_by_no_map() -> None:
    rig = Rig()
    names, keys = tuple(rig.robot.joint_names), np.asarray(rig.skin_model.key[:1], dtype=np.int64)
    learnt = SensoryMotorMap("dual_arm", names, keys, np.zeros((1, 15)), np.zeros((1, 1, 15)))
    controller = Controller(rig.robot, rig.skin_model, rig.gains, skin_map=learnt)
    with pytest.raises(InputError, match="limb_goals by a sensory-motor map"):
        controller.go(LimbGoals({"left_arm": ForceGoal(force_n=(1, 0, 0), link="left_wrist_2_link")}))
