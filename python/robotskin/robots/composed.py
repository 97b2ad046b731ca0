# SPDX-License-Identifier: Apache-2.0
"""The robots that this project composes, by name."""

from collections.abc import Callable
from math import pi
from pathlib import Path
from xml.etree import ElementTree

from robotskin.robots.catalog import named_urdf
from robotskin.robots.dual_arm import compose_dual_arm
from robotskin.robots.gripper import compose_dual_arm_gripper, compose_panda_gripper, compose_ur5_gripper
from robotskin.robots.standing import compose_talos_standing


def compose_allegro_grasp() -> tuple[str, Path]:
    """The right Allegro hand on a carriage, as one holds a glass: the palm upright, its +y up, the fingers forward.

    Joint `lift` raises it; 0 is the middle of the carriage's way.
    """
    file = named_urdf("allegro_right_hand")
    robot = ElementTree.parse(file).getroot()
    ElementTree.SubElement(robot, "link", name="mount")
    carriage = ElementTree.SubElement(robot, "link", name="carriage")
    inertial = ElementTree.SubElement(carriage, "inertial")
    ElementTree.SubElement(inertial, "mass", value="0.5")
    ElementTree.SubElement(inertial, "inertia", ixx="1e-3", iyy="1e-3", izz="1e-3", ixy="0", ixz="0", iyz="0")
    lift = ElementTree.SubElement(robot, "joint", name="lift", type="prismatic")
    ElementTree.SubElement(lift, "parent", link="mount")
    ElementTree.SubElement(lift, "child", link="carriage")
    ElementTree.SubElement(lift, "axis", xyz="0 0 1")
    ElementTree.SubElement(lift, "limit", lower="-0.25", upper="0.25", velocity="1.0", effort="200")
    joint = ElementTree.SubElement(robot, "joint", name="mount_joint", type="fixed")
    ElementTree.SubElement(joint, "parent", link="carriage")
    ElementTree.SubElement(joint, "child", link="palm_link")
    ElementTree.SubElement(joint, "origin", xyz="0 0 0", rpy=f"{pi / 2!r} 0 0")
    return ElementTree.tostring(robot, encoding="unicode"), file.parent


HAND_AHEAD_M = 0.115
"""From the arm's flange to the hand's palm frame: the hand's 95 mm, and a plate of 20 mm."""


def compose_ur5_allegro() -> tuple[str, Path]:
    """A UR5 that carries the right Allegro hand at `tool0`, fingers ahead, the palm turned to the flange's +x."""
    file = named_urdf("ur5")
    robot = ElementTree.parse(file).getroot()
    hand = ElementTree.parse(named_urdf("allegro_right_hand")).getroot()
    robot.extend(element for element in hand if element.tag in ("link", "joint"))
    joint = ElementTree.SubElement(robot, "joint", name="hand_mount", type="fixed")
    ElementTree.SubElement(joint, "parent", link="tool0")
    ElementTree.SubElement(joint, "child", link="palm_link")
    ElementTree.SubElement(joint, "origin", xyz=f"0 0 {HAND_AHEAD_M!r}", rpy="0 0 0")
    return ElementTree.tostring(robot, encoding="unicode"), file.parent


COMPOSERS: dict[str, Callable[[], tuple[str, Path]]] = {
    "allegro_grasp": compose_allegro_grasp,
    "dual_arm": compose_dual_arm,
    "dual_arm_gripper": compose_dual_arm_gripper,
    "panda_gripper": compose_panda_gripper,
    "talos_standing": compose_talos_standing,
    "ur5_allegro": compose_ur5_allegro,
    "ur5_gripper": compose_ur5_gripper,
}
"""Each gives the text of a URDF and the folder that its mesh addresses are relative to."""
