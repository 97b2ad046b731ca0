# SPDX-License-Identifier: Apache-2.0
"""Dynamics of joints in files: every model has them alike, and what cannot be used is refused by field."""

from xml.etree import ElementTree

import numpy as np
import pytest

from robotskin import robots
from robotskin.errors import UnknownNameError
from robotskin.model import RobotDynamics
from robotskin.robots.joint_dynamics import JointDynamicsError, apply_dynamics
from robotskin.world import Imperfections


def changed(text: str) -> robots.Robot:
    hand = robots.load("allegro_right_hand")
    return robots.from_text(hand.urdf, name="hand", folder=hand.source.parent, dynamics=text)


def test_mujoco_pinocchio_and_core_have_the_same(seed: int) -> None:
    random = np.random.default_rng(seed)
    damping, friction, effort = random.uniform(0.01, 1.0, 3)
    own = float(random.uniform(0.01, 1.0))
    hand = changed(
        f'[all]\ndamping = {damping}\nfriction = {friction}\neffort = {effort}\n["joint_2.0"]\ndamping = {own}\n'
    )
    index = hand.joint_names.index("joint_2.0")
    wanted = np.full(hand.joint_count, damping)
    wanted[index] = own
    model = hand.mujoco_model()
    assert hand.core.joint_damping == pytest.approx(wanted)
    assert np.ravel(model.dof_damping)[: hand.joint_count] == pytest.approx(wanted)
    assert hand.model.damping == pytest.approx(wanted)
    assert hand.effort_limit == pytest.approx(effort)
    assert hand.stated_friction == pytest.approx(dict.fromkeys(hand.joint_names, friction))
    assert model.dof_frictionloss[: hand.joint_count] == pytest.approx(friction)
    assert RobotDynamics(hand.core).joint_count == hand.joint_count


@pytest.mark.parametrize("name", ["allegro_grasp", "ur5_allegro"])
def test_a_hand_that_is_carried_has_the_fingers_of_the_hand(name: str) -> None:
    alone, hand = robots.load("allegro_right_hand"), robots.load(name)
    fingers = [hand.joint_index(joint) for joint in alone.joint_names]
    assert hand.core.joint_damping[fingers] == pytest.approx(alone.core.joint_damping)
    assert hand.effort_limit[fingers] == pytest.approx(alone.effort_limit)
    assert np.array(hand.core.rotor_inertia)[fingers] == pytest.approx(np.array(alone.core.rotor_inertia))
    assert alone.effort_limit.max() == pytest.approx(0.7)


def test_an_arm_that_carries_a_hand_is_that_arm() -> None:
    alone, carries = robots.load("ur5"), robots.load("ur5_allegro")
    arm = [carries.joint_index(joint) for joint in alone.joint_names]
    assert carries.effort_limit[arm] == pytest.approx(alone.effort_limit)
    assert np.array(carries.core.joint_damping)[arm] == pytest.approx(np.array(alone.core.joint_damping))
    assert np.array(carries.core.rotor_inertia)[arm] == pytest.approx(0)
    for joint, friction in carries.stated_friction.items():
        if joint in alone.joint_names:
            assert friction == pytest.approx(
                Imperfections().joint_friction * carries.effort_limit[carries.joint_index(joint)]
            )


@pytest.mark.parametrize(
    ("text", "told"),
    [
        ("[all]\ndamping = -1.0", "damping"),
        ("[all]\neffort = 0.0", "effort"),
        ("[all]\ninertia = 1.0", "damping, friction, effort"),
        ("[all]\ndamping = inf", "damping"),
        ("[all", "no TOML"),
        ('like = "ur5e"', "like = 'ur5e'"),
    ],
)
def test_what_cannot_be_used_is_refused_by_field(text: str, told: str) -> None:
    with pytest.raises(JointDynamicsError, match=told):
        apply_dynamics(ElementTree.fromstring('<robot name="r"/>'), text, "r.toml")


def test_an_unknown_joint_is_refused_with_those_there_are() -> None:
    with pytest.raises(UnknownNameError, match=r"joint_2\.0"):
        changed('["joint_2"]\ndamping = 0.1')
