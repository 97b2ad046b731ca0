# SPDX-License-Identifier: Apache-2.0
"""Behaviours are figure 11 and section V-E, goals choose among them, and the controller changes without harm."""

import numpy as np
import pytest
from following_robot import FollowingRobot

from robotskin.control import (
    BEHAVIOURS,
    Behaviour,
    CartesianGoal,
    Controller,
    ForceGoal,
    JointGoal,
    TaskLibrary,
    behaviour,
    primitive,
)
from robotskin.cycle import SafetyState
from robotskin.errors import InputError, UnknownNameError
from robotskin.layout import finished
from robotskin.model import ModelError, RobotDynamics
from robotskin.robots.gains import GainError, GainSet, robot_with_gains, robots_with_gains
from robotskin.selfconfig.map.sensory_motor_map import SensoryMotorMap
from robotskin.tasks import CartesianTask, ControlError, Fusion, GravityTask, JointTask, PythonTask

FIGURE_11 = {
    "skin_compliance": {"joint", "skin", "gravity"},
    "reach_joint_goal_compliant": {"spline_joint", "skin", "gravity"},
    "reach_cartesian_compliant": {"cartesian", "skin", "gravity"},
    "reach_cartesian_goal_compliant": {"spline_cartesian", "skin_cartesian", "gravity"},
    "kinesthetic_joint": {"skin", "gravity"},
    "kinesthetic_cartesian": {"skin_cartesian", "gravity"},
}
SECTION_V_E = {"propagated_compliance": {"propagated_compliance", "gravity"}}


class Rig(FollowingRobot):
    """A UR5."""

    def __init__(self, start: str = "skin_compliance", fusion: Fusion | None = None) -> None:
        super().__init__("ur5", start, fusion)

    def forearm_cell(self) -> int:
        on = np.flatnonzero(self.skin_model.link == self.skin_model.link_names.index("forearm_link"))
        return int(on[len(on) // 2])


@pytest.fixture
def rig() -> Rig:
    return Rig()


def test_behaviours_are_those_of_the_figure() -> None:
    assert {name: set(one.tasks) for name, one in BEHAVIOURS.items()} == FIGURE_11 | SECTION_V_E
    assert all(one.fusion is Fusion.weighted_sum for one in BEHAVIOURS.values())


@pytest.mark.parametrize("robot", robots_with_gains())
@pytest.mark.parametrize("name", sorted(BEHAVIOURS))
def test_every_behaviour_can_be_made_for_every_robot_with_gains(robot: str, name: str) -> None:
    ready = robot_with_gains(robot)
    controller = Controller(ready.robot.core, finished(robot).skin_model(), ready.gains, name)
    held = {"foot_contact", "balance"} if ready.robot.standing else set()
    assert set(controller.tasks) == (FIGURE_11 | SECTION_V_E)[name] | held


def test_skin_compliance_holds_and_gives_way(rig) -> None:
    assert rig.run(0.3) == SafetyState.running
    np.testing.assert_allclose(rig.joints.position, rig.gains.home, atol=1e-6)
    rig.skin.normal_force[rig.forearm_cell()] = 2.0
    rig.run(1.5)
    assert np.abs(rig.joints.position - rig.gains.home).max() > 0.02
    rig.skin.normal_force[:] = 0
    rig.run(3.0)
    np.testing.assert_allclose(rig.joints.position, rig.gains.home, atol=5e-3)


def test_a_joint_goal_is_reached(rig) -> None:
    goal = rig.gains.home + np.array([0.3, 0.1, -0.2, 0.1, 0.0, 0.2])
    rig.run(0.1)
    rig.controller.go(JointGoal(goal))
    assert rig.controller.behaviour.name == "reach_joint_goal_compliant"
    assert rig.run(5.0) == SafetyState.running
    np.testing.assert_allclose(rig.joints.position, goal, atol=2e-3)


@pytest.mark.parametrize("gradually", [True, False])
def test_a_cartesian_goal_is_reached(rig, gradually) -> None:
    rig.run(0.1)
    rig.controller.use("reach_cartesian_compliant")
    rig.run(0.1)
    task = next(task for task in rig.controller.tasks.values() if isinstance(task, CartesianTask))
    goal = task.reference
    goal[:3, 3] += [0.05, -0.08, 0.04]
    rig.controller.go(CartesianGoal(goal, gradually))
    assert rig.run(12.0) == SafetyState.running
    task = next(task for task in rig.controller.tasks.values() if isinstance(task, CartesianTask))
    np.testing.assert_allclose(task.error[:3], 0, atol=5e-3)


def test_kinesthetic_teaching_goes_where_it_is_pushed_and_stays(rig) -> None:
    rig.run(0.1)
    rig.controller.go(ForceGoal())
    rig.run(0.5)
    np.testing.assert_allclose(rig.joints.position, rig.gains.home, atol=1e-4)
    rig.skin.normal_force[rig.forearm_cell()] = 2.0
    rig.run(1.0)
    rig.skin.normal_force[:] = 0
    rig.run(0.5)
    left = rig.joints.position.copy()
    assert np.abs(left - rig.gains.home).max() > 0.01
    rig.run(1.0)
    np.testing.assert_allclose(rig.joints.position, left, atol=1e-3)


def test_a_goal_that_is_refused_changes_nothing(rig) -> None:
    rig.run(0.1)
    before = rig.controller.behaviour
    with pytest.raises(ControlError, match="reference"):
        rig.controller.go(JointGoal(np.full(6, 100.0)))
    with pytest.raises(ControlError, match="7 values"):
        rig.controller.go(JointGoal(np.zeros(7)))
    with pytest.raises(InputError, match="shape"):
        rig.controller.go(CartesianGoal(np.eye(3)))
    with pytest.raises(InputError, match="finite"):
        rig.controller.go(JointGoal([np.nan] * 6))
    assert rig.controller.behaviour == before
    with pytest.raises(UnknownNameError, match="skin_compliance"):
        rig.controller.use("skin_complience")
    rig.controller.use("kinesthetic_joint")
    with pytest.raises(InputError, match="no task that follows"):
        rig.controller.set_reference(rig.gains.home)
    assert rig.run(0.1) == SafetyState.running


def test_goals_choose_behaviours() -> None:
    assert primitive(JointGoal([0.0])).behaviour.name == "reach_joint_goal_compliant"
    assert primitive(JointGoal([0.0], gradually=False)).behaviour.name == "skin_compliance"
    assert primitive(CartesianGoal(np.eye(4))).behaviour.name == "reach_cartesian_goal_compliant"
    assert primitive(ForceGoal(hand=True)).behaviour.name == "kinesthetic_cartesian"
    with pytest.raises(InputError, match="no goal"):
        primitive("up")  # type: ignore[arg-type]


def test_a_force_goal_presses_until_the_skin_feels_it(rig) -> None:
    """Against a wall that yields like a spring, through the whole cycle."""
    name, dynamics = "wrist_2_link", RobotDynamics(rig.robot)
    link = rig.robot.link_index(name)
    cell = int(np.flatnonzero(rig.skin_model.link == rig.skin_model.link_names.index(name))[6])

    def place() -> np.ndarray:
        dynamics.update(np.array(rig.joints.position), np.zeros(6))
        return dynamics.base_from_link(link) @ rig.skin_model.link_from_cell[cell]

    rig.run(0.1)
    start, normal = place()[:3, 3], place()[:3, 2]
    rig.controller.go(ForceGoal(force_n=8.0 * normal, link=name))
    for _ in range(4_000):
        pressed = max(20_000 * float((place()[:3, 3] - start) @ normal), 0.0)
        rig.skin.normal_force[cell] = pressed / 3
        state = rig.run(0.001)
    assert state == SafetyState.running
    assert rig.controller.behaviour.name == "press"
    assert pressed == pytest.approx(8.0, abs=0.5)
    for goal, message in (
        (ForceGoal(force_n=(0, 0, 8)), "on or beyond ee_link feels .*wrist_2_link"),
        (ForceGoal(force_n=(0, 8)), r"shape \(2,\).*3\) newton"),
        (ForceGoal(force_n=(0, 0, np.nan)), r"force goal \[0.0, 0.0, nan\]"),
        (ForceGoal(force_n=(0, 0, 99), link=name), "at most 50"),
        (ForceGoal(force_n=(0, 0, 8), link="elbow"), "no link 'elbow'"),
        (JointGoal("up"), "joint goal 'up'"),
    ):
        with pytest.raises((InputError, ControlError, ModelError), match=message):
            rig.controller.go(goal)
    assert rig.controller.behaviour.name == "press"


def test_a_link_that_presses_keeps_its_levels_whatever_fusion_others_take() -> None:
    rig = Rig(fusion=Fusion.weighted_sum)
    assert rig.controller.fusion is Fusion.weighted_sum
    rig.controller.go(ForceGoal(force_n=(8, 0, 0), link="wrist_2_link"))
    assert rig.controller.fusion is Fusion.null_space


def test_a_users_task_takes_part_in_a_behaviour(rig) -> None:
    def swing(library: TaskLibrary, gains: object) -> PythonTask:
        def compute(dynamics, position, velocity, skin):
            return np.array([0.0, 0, 0, 0, 0, 30.0]), np.zeros((0, 6))

        return PythonTask("swing", 6, 0, compute)

    rig.controller.library.add("swing", swing)
    own = Behaviour("own", {"swing": 0, "joint": 0, "gravity": -1}, Fusion.weighted_sum, gains="skin_compliance")
    rig.run(0.1)
    rig.controller.use(own)
    assert rig.run(3.0) == SafetyState.running
    assert rig.joints.position[5] - rig.gains.home[5] == pytest.approx(30 / 120, rel=0.02)


def test_a_behaviour_of_ones_own_names_fusion_and_gains(rig) -> None:
    with pytest.raises(InputError, match=r"own: fusion 'weighted_sum': choose from Fusion\.weighted_sum"):
        Behaviour("own", {"joint": 0}, "weighted_sum")  # type: ignore[arg-type]
    with pytest.raises(UnknownNameError, match=r"'own': choose from .*skin_compliance"):
        rig.controller.use(Behaviour("own", {"joint": 0}, Fusion.weighted_sum))
    assert rig.controller.behaviour.name == "skin_compliance"


def test_every_gain_set_is_a_share_of_the_robots_gains() -> None:
    gains = GainSet.load("ur5")
    reaching, teaching = gains.choose("reach_joint_goal_compliant"), gains.choose("kinesthetic_joint")
    assert reaching.speed_rad_s == pytest.approx(0.6 * 0.5)
    assert max(teaching.joint.stiffness) == 0
    with pytest.raises(UnknownNameError, match="skin_compliance"):
        gains.choose("dancing")


@pytest.mark.parametrize(
    ("old", "new", "message"),
    [
        ('skin_compliance = "compliant"', 'skin_compliance = "complaint"', "names the set 'complaint'"),
        ("[sets.teaching]", "[sets.teaching]\nvigour = 2.0", "unknown field sets.teaching.vigour"),
        ("speed = 0.6", "speed = -0.6", "sets.reaching.speed is -0.6"),
        ('link = "ee_link"', "link = 3", "cartesian.link is 3"),
        ("speed_m_s = 0.15", "", "cartesian.speed_m_s is missing"),
    ],
)
def test_damaged_gain_sets_are_refused_by_field(tmp_path, old, new, message) -> None:
    from importlib import resources

    text = (resources.files("robotskin.robots.gains") / "ur5.toml").read_text(encoding="utf-8")
    path = tmp_path / "ur5.toml"
    path.write_text(text.replace(old, new, 1))
    assert path.read_text() != text
    with pytest.raises(GainError, match=message):
        GainSet.load(str(path))


@pytest.mark.parametrize("robot", robots_with_gains())
def test_a_touch_anywhere_moves_the_hand_alike(robot: str) -> None:
    """A skin Cartesian task asks for the same force on the hand, whichever cell of the limb is touched."""
    ready = robot_with_gains(robot)
    core, skin, gains = ready.robot.core, finished(robot).skin_model(), ready.gains
    chosen = gains.choose("kinesthetic_cartesian").hand_skin(core, skin)
    assert len(set(chosen.force_weight)) == 1
    assert len(set(chosen.proximity_weight)) == 1
    total, compliance = 1 + chosen.force_weight[0], gains.joint_compliance(core)
    dynamics = RobotDynamics(core)
    dynamics.update(gains.home, np.zeros(core.joint_count))
    jacobian = dynamics.link_jacobian(core.link_index(gains.values["cartesian"]["link"]))[:3]
    moved = np.trace(jacobian @ compliance @ jacobian.T) / 3 * total
    if total > 1:
        assert moved <= gains.values["skin"]["compliance_m_per_n"] * (1 + 1e-6)  # kept in single precision


def test_tasks_that_need_more_say_what_they_need(rig) -> None:
    chosen = rig.gains.choose("skin_compliance")
    with pytest.raises(InputError, match="give body"):
        rig.controller.library.make("self_collision", chosen)
    with pytest.raises(InputError, match="give skin_map"):
        rig.controller.library.make("map_skin", chosen)
    other = SensoryMotorMap("arm", ("a", "b"), np.array([1]), np.zeros((1, 2)), np.zeros((1, 1, 2)))
    with pytest.raises(InputError, match="its joints are a, b, the robot's shoulder_pan_joint"):
        TaskLibrary(rig.robot, rig.skin_model, skin_map=other)
    names = tuple(rig.robot.joint_names)
    stranger = SensoryMotorMap("ur5", names, np.array([1]), np.zeros((1, 6)), np.zeros((1, 1, 6)))
    with pytest.raises(InputError, match="none of the skin's 260 cells"):
        TaskLibrary(rig.robot, rig.skin_model, skin_map=stranger)


def test_tasks_are_made_by_name(rig) -> None:
    chosen = rig.gains.choose("skin_compliance")
    assert isinstance(rig.controller.library.make("gravity", chosen), GravityTask)
    assert isinstance(rig.controller.library.make("posture", chosen), JointTask)
    with pytest.raises(UnknownNameError, match="joint_limits"):
        rig.controller.library.make("joint_limit", chosen)
    assert behaviour("kinesthetic_joint").with_fusion(Fusion.null_space).fusion is Fusion.null_space
