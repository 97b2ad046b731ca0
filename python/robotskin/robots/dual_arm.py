# SPDX-License-Identifier: Apache-2.0
"""A robot composed by this project: two UR5 arms on a torso that an omnidirectional base carries.

It stands for the paper's TOMM (Dean-Leon et al., ICRA 2017), whose description is not public. Only what the arms are
is taken from a source (the UR5 of example-robot-data). The base has the 20 kg and the 0.75 m of length that are
published for TOMM's mobile base model, and its highest speed of 0.15 m/s; the other dimensions are this project's own.
"""

from pathlib import Path
from xml.etree import ElementTree

from robotskin.model import UNBOUNDED
from robotskin.robots.catalog import named_urdf

BASE_MASS_KG = 20.0
# What the joints x and y alone move; a body that moves must have mass.
CARRIAGE_MASS_KG = 0.1
CARRIAGE_SIZE_M = (0.1, 0.1, 0.1)
BASE_SIZE_M = (0.75, 0.60, 0.30)
BASE_SPEED_M_S = 0.15
BASE_TURN_RATE_RAD_S = 0.5
BASE_EFFORT_N = 500.0
TORSO_MASS_KG = 21.0
TORSO_SIZE_M = (0.20, 0.24, 0.70)
# A beam across the top of the torso carries the arms at its ends, their first axes turned outward by 45 degrees.
BEAM_MASS_KG = 4.0
BEAM_SIZE_M = (0.12, 0.40, 0.12)
SHOULDER_TILT_RAD = 0.7853981633974483


def compose_dual_arm() -> tuple[str, Path]:
    """The URDF text of `dual_arm` and the folder its mesh addresses are relative to.

    Joints `base_x`, `base_y` (m), `base_yaw` (rad, unbounded), then those of the UR5 with `left_` and `right_` before
    their names. Raises ModelsNotInstalledError without example-robot-data.
    """
    arm_file = named_urdf("ur5")
    arm = ElementTree.parse(arm_file).getroot()
    robot = ElementTree.Element("robot", name="dual_arm")
    ElementTree.SubElement(robot, "link", name="floor")
    _add_base_joint(robot, "base_x", "prismatic", "floor", "carriage_x", "1 0 0")
    robot.append(_box_link("carriage_x", CARRIAGE_MASS_KG, CARRIAGE_SIZE_M, with_surface=False))
    _add_base_joint(robot, "base_y", "prismatic", "carriage_x", "carriage_y", "0 1 0")
    robot.append(_box_link("carriage_y", CARRIAGE_MASS_KG, CARRIAGE_SIZE_M, with_surface=False))
    _add_base_joint(robot, "base_yaw", "revolute", "carriage_y", "mobile_base", "0 0 1")
    robot.append(_box_link("mobile_base", BASE_MASS_KG, BASE_SIZE_M))
    _add_fixed_joint(robot, "torso_mount", "mobile_base", "torso", f"0 0 {BASE_SIZE_M[2]}", "0 0 0")
    robot.append(_box_link("torso", TORSO_MASS_KG, TORSO_SIZE_M))
    beam_height = TORSO_SIZE_M[2] - BEAM_SIZE_M[2]
    _add_fixed_joint(robot, "beam_mount", "torso", "shoulder_beam", f"0 0 {beam_height}", "0 0 0")
    robot.append(_box_link("shoulder_beam", BEAM_MASS_KG, BEAM_SIZE_M))
    for side, sign in (("left_", 1.0), ("right_", -1.0)):
        shoulder = f"0 {sign * BEAM_SIZE_M[1] / 2.0} {BEAM_SIZE_M[2] / 2.0}"
        tilt = f"{-sign * SHOULDER_TILT_RAD} 0 0"
        _add_fixed_joint(robot, f"{side}mount", "shoulder_beam", f"{side}base_link", shoulder, tilt)
        robot.extend(_with_prefix(arm, side))
    return ElementTree.tostring(robot, encoding="unicode"), arm_file.parent


def _add_base_joint(robot: ElementTree.Element, name: str, kind: str, parent: str, child: str, axis: str) -> None:
    joint = _add_joint(robot, name, kind, parent, child)
    ElementTree.SubElement(joint, "axis", xyz=axis)
    speed = BASE_SPEED_M_S if kind == "prismatic" else BASE_TURN_RATE_RAD_S
    limit = {"lower": -UNBOUNDED, "upper": UNBOUNDED, "velocity": speed, "effort": BASE_EFFORT_N}
    ElementTree.SubElement(joint, "limit", {key: repr(value) for key, value in limit.items()})


def _add_fixed_joint(robot: ElementTree.Element, name: str, parent: str, child: str, xyz: str, rpy: str) -> None:
    ElementTree.SubElement(_add_joint(robot, name, "fixed", parent, child), "origin", xyz=xyz, rpy=rpy)


def _add_joint(robot: ElementTree.Element, name: str, kind: str, parent: str, child: str) -> ElementTree.Element:
    joint = ElementTree.SubElement(robot, "joint", name=name, type=kind)
    ElementTree.SubElement(joint, "parent", link=parent)
    ElementTree.SubElement(joint, "child", link=child)
    return joint


def _box_link(
    name: str, mass_kg: float, size_m: tuple[float, float, float], *, with_surface: bool = True
) -> ElementTree.Element:
    """A homogeneous box that stands on the link's origin."""
    link = ElementTree.Element("link", name=name)
    centre = f"0 0 {size_m[2] / 2.0}"
    inertial = ElementTree.SubElement(link, "inertial")
    ElementTree.SubElement(inertial, "origin", xyz=centre)
    ElementTree.SubElement(inertial, "mass", value=repr(mass_kg))
    x, y, z = (mass_kg * side**2 / 12.0 for side in size_m)
    moments = {"ixx": y + z, "iyy": x + z, "izz": x + y, "ixy": 0.0, "ixz": 0.0, "iyz": 0.0}
    ElementTree.SubElement(inertial, "inertia", {key: repr(value) for key, value in moments.items()})
    for kind in ("visual", "collision") if with_surface else ():
        shape = ElementTree.SubElement(link, kind)
        ElementTree.SubElement(shape, "origin", xyz=centre)
        geometry = ElementTree.SubElement(shape, "geometry")
        ElementTree.SubElement(geometry, "box", size=" ".join(map(repr, size_m)))
    return link


def _with_prefix(arm: ElementTree.Element, prefix: str) -> list[ElementTree.Element]:
    """Copies of the arm's links and joints, renamed, without the world it stands in."""
    copies = []
    for element in ElementTree.fromstring(ElementTree.tostring(arm)):
        parent = element.find("parent")
        in_world = element.get("name") == "world" or (parent is not None and parent.get("link") == "world")
        if element.tag not in ("link", "joint") or in_world:
            continue
        element.set("name", prefix + element.get("name", ""))
        for end in element:
            if end.tag in ("parent", "child"):
                end.set("link", prefix + end.get("link", ""))
        copies.append(element)
    return copies
