# SPDX-License-Identifier: Apache-2.0
"""Gain files: one for each robot, checked field by field, and the weights that follow from them."""

from importlib import resources

import numpy as np
import pytest

from robotskin import robots
from robotskin.layout import finished
from robotskin.model import RobotDynamics
from robotskin.robots.gains import GainError, GainSet, robots_with_gains
from robotskin.tasks import SelfCollisionGains


@pytest.fixture(scope="module")
def text() -> str:
    return (resources.files("robotskin.robots.gains") / "ur5.toml").read_text(encoding="utf-8")


def test_every_gain_file_fits_its_robot() -> None:
    for name in robots_with_gains():
        gains = GainSet.load(name)
        robot = robots.load(name, locked=gains.locked).core
        assert len(gains.home) == robot.joint_count
        assert (gains.home > robot.lower).all()
        assert (gains.home < robot.upper).all()
        gains.guard_limits(robot)


@pytest.mark.parametrize(
    ("old", "new", "message"),
    [
        ("friction_s", "fricton_s", "unknown field virtual_robot.fricton_s"),
        ("[goal]", "[gaol]", r"unknown section \[gaol\]"),
        ("force_silent_n = ", "force_silent_n = [1.0] #", r"skin.force_silent_n is \[1.0\], it must be one number"),
        ("stiffness = [", "stiffness = [nan, ", "joint.stiffness holds nan"),
        ("damping = [0.0, ", "damping = [", "joint.damping has 5 values, posture.home has 6"),
        ("[joint]", "[joint", "ur5.toml"),
        ("speed_rad_s = 0.5", "", "goal.speed_rad_s is missing"),
        ("estimator_hz = 20.0", "estimator_hz = 0", "inner_loop.estimator_hz holds 0, it must be greater than 0"),
        ("bandwidth_hz = 80.0", "bandwidth_hz = -80.0", "skin.bandwidth_hz holds -80.0, it must be at least 0"),
        ("stiffness = [2400.0", "stiffness = [0.0", "joint.stiffness holds 0.0, it must be greater than 0"),
    ],
)
def test_a_damaged_file_is_refused_by_field(text, tmp_path, old, new, message) -> None:
    path = tmp_path / "ur5.toml"
    path.write_text(text.replace(old, new, 1))
    assert path.read_text() != text
    with pytest.raises(GainError, match=message):
        GainSet.load(str(path))


def test_a_home_beyond_a_joint_limit_and_a_file_that_is_no_text_are_refused(text, tmp_path) -> None:
    path = tmp_path / "ur5.toml"
    path.write_text(text.replace("home = [0.0, -1.4", "home = [0.0, -9.4"))
    with pytest.raises(GainError, match=r"posture.home of shoulder_lift_joint is -9.4: -6.28"):
        GainSet.load(str(path)).guard_limits(robots.load("ur5").core)
    path.write_bytes(b"\xff\x00")
    with pytest.raises(GainError, match=r"ur5.toml: .*decode"):
        GainSet.load(str(path))


def test_a_file_may_keep_more_of_the_velocity_limits_for_what_a_hand_adds(text, tmp_path) -> None:
    path, robot = tmp_path / "ur5.toml", robots.load("ur5").core
    usual = GainSet.load("ur5").guard_limits(robot).speed_share
    path.write_text(text.replace("[limits]", f"[limits]\nspeed_share = {usual / 2}", 1))
    assert GainSet.load(str(path)).guard_limits(robot).speed_share == usual / 2


def test_an_unknown_robot_is_refused_with_the_choices() -> None:
    with pytest.raises(GainError, match="make some: robotskin gains ur6"):
        GainSet.load("ur6")


def test_gains_do_not_pass_for_another_robot() -> None:
    panda = robots.load("panda").core
    with pytest.raises(GainError, match="6 joints, the robot has 9"):
        GainSet.load("ur5").guard_limits(panda)


def test_a_standing_robot_gives_as_far_as_stated_although_it_leans_against_the_touch() -> None:
    robot, skin, gains = (
        robots.load("talos_standing").core,
        finished("talos_standing").skin_model(),
        GainSet.load("talos_standing"),
    )
    jacobian, lever = gains.levers(robot, skin)
    weight, compliance = gains.force_weights(robot, skin), gains.joint_compliance(robot)
    given = np.einsum("cij,cj->ci", jacobian, lever @ compliance) * (1 + weight[:, None])
    leaning = np.einsum("cij,cj->ci", jacobian, gains.leaning(robot, skin))
    of_joints = np.array(gains.values["skin"]["largest_force_weight_by_joint"])
    moves = np.abs(jacobian).max(axis=1) > 0
    largest = np.maximum(gains.values["skin"]["largest_force_weight"], (moves * of_joints).max(axis=1))
    assert (weight <= largest).all()
    assert len(np.unique(largest)) == 3, "legs, trunk and arms have bounds of their own"
    free = (weight > 0) & (weight < largest)
    assert free.sum() > 30
    stated = gains.values["skin"]["compliance_m_per_n"]
    most = gains.values["skin"]["largest_give_rad_per_n"]
    bounded = (np.abs(lever @ compliance).max(axis=1) * (1 + weight)) > 0.999 * most
    assert np.allclose(np.linalg.norm(given + leaning, axis=1)[free & ~bounded], stated)
    assert (np.einsum("ci,ci->c", given, leaning)[free] < 0).mean() > 0.9
    assert not GainSet.load("ur5").leaning(robots.load("ur5").core, finished("ur5").skin_model()).any()


def test_nearness_moves_the_trunk_of_a_standing_robot_farther_than_a_touch_and_all_else_alike() -> None:
    robot, layout, gains = (
        robots.load("talos_standing").core,
        finished("talos_standing"),
        GainSet.load("talos_standing"),
    )
    skin = layout.skin_model()
    touch, near = gains.weights(robot, skin)
    assert (touch == gains.force_weights(robot, skin)).all()
    trunk = np.array([layout.links[link] == "torso_2_link" for link in layout.link])
    assert (near[trunk] > 1.3 * touch[trunk]).mean() > 0.9
    below = np.array([layout.links[link].startswith(("leg", "base")) for link in layout.link])
    assert (near[below] == touch[below]).all()
    newton = gains.values["skin"]["proximity_n"]
    assert np.allclose(gains.skin_gains(robot, skin).proximity_weight, newton * (1 + near))
    ur5, own, stated = robots.load("ur5").core, finished("ur5").skin_model(), GainSet.load("ur5")
    of_touch, of_nearness = stated.weights(ur5, own)
    assert (of_nearness == of_touch).all()


def test_what_the_gains_promise_holds_for_the_finished_skin() -> None:
    """15 N move no cell by 5 mm without the skin task, and most by 0.03 to 0.15 m with it."""
    robot, skin, gains = robots.load("ur5").core, finished("ur5").skin_model(), GainSet.load("ur5")
    stiff = gains.stiff_compliance(robot, skin)
    soft = stiff * (1 + gains.force_weights(robot, skin))
    assert (15 * stiff).max() < 0.004
    assert (15 * soft).max() < 0.1
    for link in ("upper_arm_link", "forearm_link", "wrist_1_link", "wrist_2_link"):
        cells = skin.link == skin.link_names.index(link)
        assert np.median(15 * soft[cells]) > 0.03


def test_a_robot_on_its_feet_asks_of_its_upper_body_what_its_motors_bear() -> None:
    """As a strong touch ends all of it comes back at once; motors that are overdriven work against each other."""
    robot, gains = robots.load("talos_standing"), GainSet.load("talos_standing")
    dynamics = RobotDynamics(robot.core)
    dynamics.update(np.array(gains.home), np.zeros(robot.joint_count))
    inertia = np.diag(np.array(dynamics.mass_matrix).reshape(robot.joint_count, -1))
    spare = np.array(robot.effort_limit) - np.abs(np.array(dynamics.nonlinear_effects))
    acceleration = np.array(gains.values["limits"]["acceleration"])
    upper = [row for row, name in enumerate(robot.joint_names) if not name.startswith(("base", "leg"))]
    assert len(upper) == 20
    assert (acceleration * inertia <= spare)[upper].all()


def test_bodies_keep_apart_as_stiffly_as_the_file_states(text, tmp_path) -> None:
    path = tmp_path / "ur5.toml"
    path.write_text(text)
    usual = SelfCollisionGains()
    unstated = GainSet.load(str(path)).self_collision_gains()
    assert (unstated.stiffness, unstated.damping) == (usual.stiffness, usual.damping)
    path.write_text(
        text.replace("[limits]", "[limits]\nself_collision_stiffness = 7e4\nself_collision_damping = 6e3", 1)
    )
    stated = GainSet.load(str(path)).self_collision_gains()
    assert (stated.stiffness, stated.damping, stated.safe_m) == (7e4, 6e3, usual.safe_m)
    path.write_text(text.replace("[limits]", "[limits]\nself_collision_damping = 0.0", 1))
    with pytest.raises(GainError, match=r"limits.self_collision_damping holds 0.0, it must be greater than 0"):
        GainSet.load(str(path))
