# SPDX-License-Identifier: Apache-2.0
"""Robots that stand on feet of their own: a base that nothing drives, soles on a floor, and where their sensors are.

The base hangs on six joints of one degree of freedom (three slides, then yaw, pitch and roll) between the link `world`
and the robot's own first link. Their effort limit is 0, which makes them unactuated. So a standing robot is a tree of
joints like any other, and its base link `world` is the floor under it.
"""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from xml.etree import ElementTree

from robotskin import tasks as core
from robotskin.model import UNBOUNDED, RobotModel
from robotskin.robots.catalog import named_urdf

BASE_JOINTS = ("base_x", "base_y", "base_z", "base_yaw", "base_pitch", "base_roll")
"""In their order; the first three in m, the others in rad."""
BASE_SPEED_M_S = 5.0
BASE_TURN_RATE_RAD_S = 10.0
CARRIER_MASS_KG = 1e-3
"""Of what hangs between two of these joints; a body that moves must have mass."""


@dataclass(frozen=True)
class Foot:
    """A foot and its flat sole, a box under it. `link`: the foot's; its frame has z up where the robot stands.

    sole_m: (x, y, z) of the middle of the sole's lower face in that frame; half_m: (x, y) half its length and width.
    """

    link: str
    sole_m: tuple[float, float, float]
    half_m: tuple[float, float]


@dataclass(frozen=True)
class Standing:
    """What a robot stands on, the link that carries its inertial unit, and its name where it is mounted instead."""

    feet: tuple[Foot, Foot]
    imu_link: str
    mounted: str


# The sole ends 4 mm below the cells under the foot, which so carry none of the robot's weight.
_TALOS_SOLE = ((-0.0059, 0.0, -0.118), (0.1104, 0.0672))

STANDING = {
    "talos_standing": Standing(
        (Foot("leg_left_6_link", *_TALOS_SOLE), Foot("leg_right_6_link", *_TALOS_SOLE)), "imu_link", "talos"
    ),
}
"""By name of the robot."""

SOLE_THICKNESS_M = 0.02


def feet_of(robot: RobotModel) -> list[core.Foot]:
    """The feet of a robot that stands, as the core takes them; none of one that is mounted."""
    standing = STANDING.get(robot.name)
    return [] if standing is None else [core.Foot(foot.link, foot.sole_m, foot.half_m) for foot in standing.feet]


def compose_talos_standing() -> tuple[str, Path]:
    """Talos on its feet: joints `BASE_JOINTS`, then its own 32. Raises ModelsNotInstalledError."""
    return _on_feet("talos")


def _on_feet(name: str) -> tuple[str, Path]:
    file = named_urdf(name)
    robot = ElementTree.parse(file).getroot()
    children = {child.get("link") for child in robot.iterfind("joint/child")}
    first = next(link.get("name", "") for link in robot.findall("link") if link.get("name") not in children)
    ElementTree.SubElement(robot, "link", name="world")
    above = "world"
    for index, joint_name in enumerate(BASE_JOINTS):
        below = first if index == len(BASE_JOINTS) - 1 else f"{joint_name}_carrier"
        slides = index < 3
        joint = ElementTree.SubElement(robot, "joint", name=joint_name, type="prismatic" if slides else "revolute")
        ElementTree.SubElement(joint, "parent", link=above)
        ElementTree.SubElement(joint, "child", link=below)
        axis = index if slides else 5 - index
        ElementTree.SubElement(joint, "axis", xyz=" ".join("1" if axis == one else "0" for one in range(3)))
        speed = BASE_SPEED_M_S if slides else BASE_TURN_RATE_RAD_S
        limit = {"lower": -UNBOUNDED, "upper": UNBOUNDED, "velocity": speed, "effort": 0.0}
        ElementTree.SubElement(joint, "limit", {key: repr(value) for key, value in limit.items()})
        if below != first:
            inertial = ElementTree.SubElement(ElementTree.SubElement(robot, "link", name=below), "inertial")
            ElementTree.SubElement(inertial, "mass", value=repr(CARRIER_MASS_KG))
            moments = {"ixx": 1e-6, "iyy": 1e-6, "izz": 1e-6, "ixy": 0.0, "ixz": 0.0, "iyz": 0.0}
            ElementTree.SubElement(inertial, "inertia", {key: repr(value) for key, value in moments.items()})
        above = below
    return ElementTree.tostring(robot, encoding="unicode"), file.parent
