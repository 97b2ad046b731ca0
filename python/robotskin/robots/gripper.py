# SPDX-License-Identifier: Apache-2.0
"""Robots composed by this project: arms that end in a parallel gripper whose two pads are large enough for skin.

No gripper that is sold has pads of the size of several cells, so the dimensions are this project's own: pads of 62 by
62 mm, 60 N, and a stroke of 100 mm between the faces of their skins. A pad's joint counts its skin's distance from the
middle: 0 closed, 0.05 m open. The frame of a pad lies in the middle of its inner face, whose normal is its own +z.
"""

from collections.abc import Iterable
from math import pi
from pathlib import Path
from xml.etree import ElementTree

from robotskin import firmware
from robotskin.robots.catalog import named_urdf
from robotskin.robots.dual_arm import compose_dual_arm

PAD_M = 0.062
PAD_THICKNESS_M = 0.014
SKIN_M = 0.003 + firmware.CELL_THICKNESS_M
"""Foam and cell."""
STROKE_M = 0.05
"""Of one pad."""
EFFORT_N = 60.0
SPEED_M_S = 0.15
PAD_MASS_KG = 0.15
BODY_MASS_KG = 0.6
BODY_M = (0.09, 0.19, 0.05)
GAP_M = 0.004
"""Between body and pads."""

Composed = tuple[str, Path]


def compose_ur5_gripper() -> Composed:
    """A UR5 with the gripper at `tool0`; joints `left_pad_joint` and `right_pad_joint` follow its six."""
    file = named_urdf("ur5")
    robot = ElementTree.parse(file).getroot()
    _add_gripper(robot, "tool0", "")
    return _text(robot), file.parent


def compose_dual_arm_gripper() -> Composed:
    """The dual-arm robot with a gripper on each arm; their links and joints begin with `left_` and `right_`."""
    text, folder = compose_dual_arm()
    robot = ElementTree.fromstring(text)
    for side in ("left_", "right_"):
        _add_gripper(robot, f"{side}tool0", side)
    return _text(robot), folder


def compose_panda_gripper() -> Composed:
    """A Panda with the gripper in place of its hand, turned as that is."""
    file = named_urdf("panda")
    robot = ElementTree.parse(file).getroot()
    _remove_beyond(robot, "panda_link8")
    _add_gripper(robot, "panda_link8", "", yaw_rad=-pi / 4)
    return _text(robot), file.parent


def _text(robot: ElementTree.Element) -> str:
    return ElementTree.tostring(robot, encoding="unicode")


def _remove_beyond(robot: ElementTree.Element, link: str) -> None:
    """Takes away everything that hangs on a link."""
    gone: set[str] = set()
    reached = {link}
    while reached:
        joints = [joint for joint in robot.findall("joint") if _end(joint, "parent") in reached]
        reached = {_end(joint, "child") for joint in joints}
        gone |= reached
        for joint in joints:
            robot.remove(joint)
    for element in [one for one in robot.findall("link") if one.get("name") in gone]:
        robot.remove(element)


def _end(joint: ElementTree.Element, which: str) -> str:
    end = joint.find(which)
    return "" if end is None else end.get("link", "")


def _add_gripper(robot: ElementTree.Element, mount: str, prefix: str, yaw_rad: float = 0.0) -> None:
    body = f"{prefix}gripper"
    robot.append(_box(body, BODY_MASS_KG, BODY_M, (0.0, 0.0, BODY_M[2] / 2)))
    _joint(robot, f"{prefix}gripper_mount", "fixed", mount, body, (0, 0, 0), (0, 0, yaw_rad))
    ahead = BODY_M[2] + GAP_M + PAD_M / 2
    # Seen along the approach the left pad is on +y. Its inner face looks to -y, and its joint opens along its -z.
    for side, sign in (("left", 1.0), ("right", -1.0)):
        pad = f"{prefix}{side}_pad"
        robot.append(_box(pad, PAD_MASS_KG, (PAD_M, PAD_M, PAD_THICKNESS_M), (0.0, 0.0, -PAD_THICKNESS_M / 2)))
        turn = (sign * pi / 2, 0.0, 0.0)
        joint = _joint(robot, f"{pad}_joint", "prismatic", body, pad, (0.0, sign * SKIN_M, ahead), turn)
        ElementTree.SubElement(joint, "axis", xyz="0 0 -1")
        limit = {"lower": 0.0, "upper": STROKE_M, "velocity": SPEED_M_S, "effort": EFFORT_N}
        ElementTree.SubElement(joint, "limit", {key: repr(value) for key, value in limit.items()})
        ElementTree.SubElement(joint, "dynamics", damping="20.0")


def _joint(
    robot: ElementTree.Element,
    name: str,
    kind: str,
    parent: str,
    child: str,
    place_m: Iterable[float],
    turn_rad: Iterable[float],
) -> ElementTree.Element:
    joint = ElementTree.SubElement(robot, "joint", name=name, type=kind)
    ElementTree.SubElement(joint, "parent", link=parent)
    ElementTree.SubElement(joint, "child", link=child)
    ElementTree.SubElement(joint, "origin", xyz=_numbers(place_m), rpy=_numbers(turn_rad))
    return joint


def _box(
    name: str, mass_kg: float, size_m: tuple[float, float, float], centre_m: tuple[float, float, float]
) -> ElementTree.Element:
    """A homogeneous box about a point of the link's frame."""
    link = ElementTree.Element("link", name=name)
    inertial = ElementTree.SubElement(link, "inertial")
    ElementTree.SubElement(inertial, "origin", xyz=_numbers(centre_m))
    ElementTree.SubElement(inertial, "mass", value=repr(mass_kg))
    x, y, z = (mass_kg * side**2 / 12.0 for side in size_m)
    moments = {"ixx": y + z, "iyy": x + z, "izz": x + y, "ixy": 0.0, "ixz": 0.0, "iyz": 0.0}
    ElementTree.SubElement(inertial, "inertia", {key: repr(value) for key, value in moments.items()})
    for kind in ("visual", "collision"):
        shape = ElementTree.SubElement(link, kind)
        ElementTree.SubElement(shape, "origin", xyz=_numbers(centre_m))
        ElementTree.SubElement(ElementTree.SubElement(shape, "geometry"), "box", size=_numbers(size_m))
    return link


def _numbers(values: Iterable[float]) -> str:
    return " ".join(repr(float(value)) for value in values)
