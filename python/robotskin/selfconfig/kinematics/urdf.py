# SPDX-License-Identifier: Apache-2.0
"""The text of a URDF for a robot that its skin has found."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from xml.etree import ElementTree

import numpy as np
from scipy.spatial.transform import Rotation

from robotskin.selfconfig.kinematics.frames import DenavitHartenberg
from robotskin.selfconfig.kinematics.screw_tree import ScrewTree

BASE_LINK = "base"


@dataclass(frozen=True)
class JointBounds:
    """lower_rad, upper_rad; velocity_radps; effort_nm."""

    lower_rad: float
    upper_rad: float
    velocity_radps: float
    effort_nm: float


UNBOUNDED = JointBounds(-2 * np.pi, 2 * np.pi, 1.0, 0.0)
"""What stands where nothing was told: URDF wants a number, and no force is granted."""


def link_name(joint: str) -> str:
    """Of the link behind a joint."""
    return f"behind_{joint}"


def kinematic_urdf(
    tree: ScrewTree, table: tuple[DenavitHartenberg, ...], name: str, bounds: Mapping[str, JointBounds]
) -> str:
    """A link `base`, and one behind each joint, in the frames of the parameters.

    Args:
        tree: whose joints' parents are wanted.
        table: a row a joint.
        name: of the robot.
        bounds: by joint name.
    """
    robot = ElementTree.Element("robot", name=name)
    ElementTree.SubElement(robot, "link", name=BASE_LINK)
    for row, one in enumerate(table):
        ElementTree.SubElement(robot, "link", name=link_name(one.joint))
        joint = ElementTree.SubElement(robot, "joint", name=one.joint, type="revolute")
        parent = int(tree.parent[row])
        ElementTree.SubElement(joint, "parent", link=link_name(table[parent].joint) if parent >= 0 else BASE_LINK)
        ElementTree.SubElement(joint, "child", link=link_name(one.joint))
        place = one.parent_from_joint()
        # URDF's roll, pitch, yaw turn about fixed axes.
        angles = Rotation.from_matrix(place[:3, :3]).as_euler("xyz")
        ElementTree.SubElement(joint, "origin", xyz=_text(place[:3, 3]), rpy=_text(angles))
        ElementTree.SubElement(joint, "axis", xyz="0 0 1")
        limit = bounds.get(one.joint, UNBOUNDED)
        ElementTree.SubElement(
            joint,
            "limit",
            lower=repr(float(limit.lower_rad)),
            upper=repr(float(limit.upper_rad)),
            velocity=repr(float(limit.velocity_radps)),
            effort=repr(float(limit.effort_nm)),
        )
    ElementTree.indent(robot)
    return ElementTree.tostring(robot, encoding="unicode")


def _text(values: np.ndarray) -> str:
    return " ".join(repr(float(value)) for value in values)
