# SPDX-License-Identifier: Apache-2.0
"""Goals that a robot on feet cannot reach, or in which it would fall, are refused with the bound that they break."""

import numpy as np
import pytest
from following_robot import FollowingRobot

from robotskin import robots
from robotskin.control import CartesianGoal, Controller, ForceGoal, JointGoal, LimbGoals
from robotskin.control.goal_bounds import require_balance, require_reach
from robotskin.errors import InputError
from robotskin.model import RobotDynamics, RobotModel
from robotskin.robots.gains import GainSet
from robotskin.robots.standing import BASE_JOINTS

HAND, OTHER_HAND, FOOT = "gripper_left_base_link", "gripper_right_base_link", "leg_left_6_link"
OUTSIDE = r"centre of mass would be \d+ mm outside of the soles; it has to be 30 mm inside"
NOT_LEVEL = "from one level floor; at most 10 mm and 3 degrees"
SIDES = ("left", "right")


@pytest.fixture(scope="module")
def robot() -> RobotModel:
    return robots.load("talos_standing").core


@pytest.fixture(scope="module")
def home() -> np.ndarray:
    return np.array(GainSet.load("talos_standing").home)


@pytest.fixture
def controller() -> Controller:
    return FollowingRobot("talos_standing").controller


def changed(robot: RobotModel, posture: np.ndarray, by: dict[str, float]) -> np.ndarray:
    result = posture.copy()
    for joint, change in by.items():
        result[list(robot.joint_names).index(joint)] += change
    return result


def leaning(robot: RobotModel, posture: np.ndarray, angle: float) -> np.ndarray:
    return changed(robot, posture, {f"leg_{side}_5_joint": angle for side in SIDES})


def moved(robot: RobotModel, posture: np.ndarray, link: str, by_m: tuple[float, float, float]) -> np.ndarray:
    dynamics = RobotDynamics(robot)
    dynamics.update(posture, np.zeros(robot.joint_count))
    pose = np.array(dynamics.base_from_link(robot.link_index(link)))
    pose[:3, 3] += by_m
    return pose


def lifted(robot: RobotModel, home: np.ndarray) -> np.ndarray:
    return changed(robot, home, {"leg_left_4_joint": 0.4})


def test_a_posture_beyond_balance_is_refused_with_the_bound_that_it_breaks(robot, home) -> None:
    require_balance(robot, home)
    elsewhere = home.copy()
    elsewhere[:4] += (0.3, -0.2, 0.1, 1.0)
    require_balance(robot, elsewhere)  # where the base would be is not looked at
    with pytest.raises(InputError, match=OUTSIDE):
        require_balance(robot, leaning(robot, home, 0.2))
    with pytest.raises(InputError, match=NOT_LEVEL):
        require_balance(robot, lifted(robot, home))
    require_balance(robots.load("ur5").core, np.zeros(6))


def test_joint_goals_beyond_balance_are_refused_however_they_are_given(controller, robot, home) -> None:
    controller.go(JointGoal(changed(robot, home, {"arm_left_4_joint": 0.5, "torso_2_joint": 0.5})))
    before = controller.behaviour
    for give in (
        lambda posture: controller.go(JointGoal(posture)),
        lambda posture: controller.go(JointGoal(posture, gradually=False)),
        controller.request_goal,
        controller.set_reference,
    ):
        give(home)
        with pytest.raises(InputError, match=OUTSIDE):
            give(leaning(robot, home, 0.2))
        with pytest.raises(InputError, match=NOT_LEVEL):
            give(lifted(robot, home))
    controller.go(JointGoal(home))
    with pytest.raises(InputError, match=OUTSIDE):
        controller.go(JointGoal(leaning(robot, home, 0.2), gradually=False))
    assert controller.behaviour.name == before.name, "a refused goal changes nothing"
    with pytest.raises(InputError, match="joint goal of 7 numbers: talos_standing has 38 joints"):
        controller.go(JointGoal(np.zeros(7)))


@pytest.mark.parametrize("by_m", [(2.0, 0.0, 0.0), (0.0, 0.0, 3.0), (0.0, 0.0, -1.2)])
def test_a_hand_that_no_arm_brings_there_is_not_brought_there_by_the_base(controller, robot, home, by_m) -> None:
    before = controller.behaviour
    for gradually in (True, False):
        with pytest.raises(InputError, match=f"out of reach, {HAND} comes no nearer than .* at the limit"):
            controller.go(CartesianGoal(moved(robot, home, HAND, by_m), gradually))
    assert controller.behaviour is before, "a refused goal changes nothing"
    near = moved(robot, home, HAND, tuple(0.05 * np.sign(by_m)))
    controller.go(CartesianGoal(near))
    with pytest.raises(InputError, match="out of reach"):
        controller.set_reference(moved(robot, home, HAND, by_m))
    controller.set_reference(near)


def test_what_a_hand_reaches_is_reached_by_the_joints_that_carry_it(robot, home, seed: int) -> None:
    """A place that some posture in balance has is reached, with base and legs where they were."""
    draw, names = np.random.default_rng(seed), list(robot.joint_names)
    carries = [at for at, name in enumerate(names) if name.startswith(("torso", "arm_left"))]
    low, high = np.maximum(robot.lower, home - 0.4), np.minimum(robot.upper, home + 0.4)
    for _ in range(5):
        posture = home.copy()
        posture[carries] = draw.uniform(low[carries], high[carries])
        require_balance(robot, posture)
        point = moved(robot, posture, HAND, (0.0, 0.0, 0.0))[:3, 3]
        found = require_reach(robot, HAND, point, home)
        assert moved(robot, found, HAND, (0.0, 0.0, 0.0))[:3, 3] == pytest.approx(point, abs=1e-3)
        still = [at for at, name in enumerate(names) if name.startswith("leg") or name in BASE_JOINTS]
        assert np.array_equal(found[still], home[still])


def test_a_hand_goal_of_a_robot_that_leans_is_refused_where_it_would_tip(controller, robot, home) -> None:
    controller.joints = FollowingRobot("talos_standing").joints
    leant = leaning(robot, home, -0.07)
    controller.joints.position = leant
    controller.go(CartesianGoal(moved(robot, leant, HAND, (0.0, 0.0, 0.05))))
    with pytest.raises(InputError, match=r"goal at .* m: the centre of mass would be \d+ mm inside of the soles"):
        controller.go(CartesianGoal(moved(robot, leant, HAND, (0.45, 0.0, 0.0))))


def test_a_foot_that_is_to_leave_the_floor_is_refused(controller, robot, home) -> None:
    with pytest.raises(InputError, match=NOT_LEVEL):
        controller.go(CartesianGoal(moved(robot, home, FOOT, (0.0, 0.0, 0.08)), link=FOOT))


def test_goals_of_limbs_are_judged_together(controller, robot, home) -> None:
    index = {name: at for at, name in enumerate(robot.joint_names)}

    def leg(side: str, ankle: float, knee: float = 0.0) -> JointGoal:
        joints = [f"leg_{side}_{number}_joint" for number in range(1, 7)]
        by = {f"leg_{side}_5_joint": ankle, f"leg_{side}_4_joint": knee}
        return JointGoal(changed(robot, home, by)[[index[joint] for joint in joints]])

    with pytest.raises(InputError, match=OUTSIDE):
        controller.go(LimbGoals({f"leg_{side}_1_joint": leg(side, 0.2) for side in SIDES}))
    with pytest.raises(InputError, match=NOT_LEVEL):
        controller.go(LimbGoals({"leg_left_1_joint": leg("left", 0.0, 0.4)}))
    controller.go(LimbGoals({f"leg_{side}_1_joint": leg(side, 0.03) for side in SIDES}))

    near, far = ((moved(robot, home, HAND, (ahead, 0.0, 0.0))) for ahead in (0.1, 0.45))
    limbs = {"arm_right_1_joint": ForceGoal()}
    controller.go(LimbGoals({"arm_left_1_joint": CartesianGoal(near, link=HAND), **limbs}))
    with pytest.raises(InputError, match=f"out of reach, {HAND}"):
        controller.go(LimbGoals({"arm_left_1_joint": CartesianGoal(far, link=HAND), **limbs}))
    controller.go(CartesianGoal(far))  # that the torso helps an arm is the whole robot's goal
    controller.go(LimbGoals({"arm_left_1_joint": ForceGoal(force_n=(5, 0, 0), link="arm_left_4_link"), **limbs}))


def test_a_mounted_robot_may_stretch(robot) -> None:
    rig = FollowingRobot("ur5")
    pose = np.eye(4)
    pose[:3, 3] = (5.0, 0.0, 0.0)
    rig.controller.go(CartesianGoal(pose))
