# SPDX-License-Identifier: Apache-2.0
"""Two feet of an exoskeleton: their links and joints, insoles, and seven cells under each."""

from __future__ import annotations

from enum import IntEnum
from pathlib import Path
from xml.etree import ElementTree

import numpy as np
from numpy.typing import NDArray

from robotskin.firmware import PORT_POINTS_M
from robotskin.layout import Layout, Patch, SectionUnitPort
from robotskin.robots import Robot
from robotskin.robots.loading import from_text

Array = NDArray[np.float64]

NAME = "exoskeleton_feet"
SIDES = ("left", "right")
JOINTS = ("x", "z", "pitch")
"""Of each foot, in this order: forwards and upwards in metres; the pitch in rad, toes down."""
HALF_STANCE_M = 0.11
SOLE_Z_M = -0.09
"""The faces of the cells in the foot's frame, whose origin is the ankle."""
SHANK_KG, FOOT_KG = 4.0, 6.0
"""What follows the generated gait; with the servo's stiffness it makes the leg a spring."""
TOE_M, HEEL_M = 0.127, -0.127
"""Where the outermost cells end."""


class Region(IntEnum):
    """Of a sole; each has a motor of its own."""

    FRONT = 0
    CENTRE = 1
    BACK = 2


ROWS = ((Region.FRONT, 0.115, 3), (Region.CENTRE, 0.0, 2), (Region.BACK, -0.115, 2))
"""Region, place along the foot in metres, and cells of each row."""
REGIONS = np.array([region for region, _, count in ROWS for _ in range(count)])
"""(7,) of the cells of one sole."""

# Beside the cells an insole carries most of the load. (first and last x, lower face above the cells' faces), metres.
_PADS = ((0.06, 0.10, 0.0001), (0.015, 0.045, 0.0001), (-0.10, -0.06, 0.0001))
# Toe and heel are rounded, so that cells meet the ground first.
_RIMS = ((0.1295, 0.1355, 0.0011), (-0.1355, -0.1295, 0.0011))
_HALF_WIDTH_M = 0.0555


def robot() -> Robot:
    """Six joints: each foot goes forwards, upwards, and pitches."""
    root = ElementTree.Element("robot", name=NAME)
    ElementTree.SubElement(root, "link", name="ground")
    for side, y in zip(SIDES, (HALF_STANCE_M, -HALF_STANCE_M), strict=True):
        _link(root, f"{side}_carriage", 0.1, ())
        _link(
            root,
            f"{side}_shank",
            SHANK_KG,
            (((0.0, 0.0, 0.21), (0.055, 0.09, 0.30)), ((0, 0, 0.03), (0.05, 0.12, 0.08))),
        )
        pads = [
            (((a + b) / 2, 0.0, SOLE_Z_M + up + 0.01), (b - a, 2 * _HALF_WIDTH_M, 0.02)) for a, b, up in _PADS + _RIMS
        ]
        upper = [((0.0, 0.0, SOLE_Z_M + 0.0285), (0.271, 0.111, 0.025)), ((-0.035, 0, -0.03), (0.15, 0.10, 0.065))]
        _link(root, f"{side}_foot", FOOT_KG, upper, pads)
        _joint(root, f"{side}_x", "prismatic", "ground", f"{side}_carriage", (1, 0, 0), (0.0, y, 0.0))
        _joint(root, f"{side}_z", "prismatic", f"{side}_carriage", f"{side}_shank", (0, 0, 1))
        _joint(root, f"{side}_pitch", "revolute", f"{side}_shank", f"{side}_foot", (0, 1, 0))
    return from_text(ElementTree.tostring(root, encoding="unicode"), name=NAME, folder=Path())


def _link(
    root: ElementTree.Element,
    name: str,
    mass_kg: float,
    seen: object,
    pads: object = (),
) -> None:
    link = ElementTree.SubElement(root, "link", name=name)
    inertial = ElementTree.SubElement(link, "inertial")
    ElementTree.SubElement(inertial, "mass", value=repr(mass_kg))
    moments = {"ixx": 0.1, "iyy": 0.1, "izz": 0.1, "ixy": 0.0, "ixz": 0.0, "iyz": 0.0}
    ElementTree.SubElement(inertial, "inertia", {key: repr(value) for key, value in moments.items()})
    for kind, boxes in (("visual", seen), ("collision", pads)):
        for centre, lengths in boxes:  # type: ignore[attr-defined]
            part = ElementTree.SubElement(link, kind)
            ElementTree.SubElement(part, "origin", xyz=" ".join(map(repr, map(float, centre))))
            box = ElementTree.SubElement(ElementTree.SubElement(part, "geometry"), "box")
            box.set("size", " ".join(map(repr, map(float, lengths))))


def _joint(
    root: ElementTree.Element,
    name: str,
    kind: str,
    parent: str,
    child: str,
    axis: tuple[int, int, int],
    at: tuple[float, float, float] = (0.0, 0.0, 0.0),
) -> None:
    joint = ElementTree.SubElement(root, "joint", name=name, type=kind)
    ElementTree.SubElement(joint, "parent", link=parent)
    ElementTree.SubElement(joint, "child", link=child)
    ElementTree.SubElement(joint, "origin", xyz=" ".join(map(repr, at)))
    ElementTree.SubElement(joint, "axis", xyz=" ".join(map(str, axis)))
    far = 1000.0 if kind == "prismatic" else 1.0
    ElementTree.SubElement(joint, "limit", lower=repr(-far), upper=repr(far), velocity="20", effort="100000")


def skin() -> Layout:
    """Fourteen cells, seven under each foot, every one reachable on two ways."""
    poses = _sole()
    neighbours = np.zeros((14, 4, 2), dtype=np.int32)
    neighbours[:, :, 0] = -1
    for first in (0, 7):
        for a, port_a, b, port_b in _WIRES:
            neighbours[first + a, port_a - 1] = (first + b, port_b)
            neighbours[first + b, port_b - 1] = (first + a, port_a)
    names = [region.name.lower() for region, _, _ in ROWS]
    roots = [int(np.flatnonzero(region == REGIONS)[0]) for region, _, _ in ROWS]
    links = tuple(f"{side}_foot" for side in SIDES)
    return Layout(
        robot=NAME,
        links=links,
        id=np.arange(1, 15, dtype=np.uint16),
        group=np.ones(14, dtype=np.uint16),
        link=np.repeat([0, 1], 7).astype(np.int32),
        link_from_cell=np.concatenate([poses, poses]),
        neighbours=neighbours,
        patch=np.concatenate([REGIONS, REGIONS + 3]).astype(np.int32),
        patches=tuple(
            Patch(f"{side}_{name}", f"{side}_foot", 7 * foot + root)
            for foot, side in enumerate(SIDES)
            for name, root in zip(names, roots, strict=True)
        ),
        section_unit_ports=tuple(
            SectionUnitPort(1, 2 * foot + one + 1, 7 * foot + cell, 2)
            for foot in range(2)
            for one, cell in enumerate((1, 5))
        ),
        source="robotskin.apps.feet",
    )


# Cell, port, cell, port: along the rows, then between them on both sides of the foot.
_WIRES = (
    *((0, 1, 1, 4), (1, 1, 2, 4), (3, 1, 4, 4), (5, 1, 6, 4)),
    *((0, 2, 3, 3), (2, 2, 4, 3), (3, 2, 5, 3), (4, 2, 6, 3)),
)


def _sole() -> Array:
    """(7, 4, 4) foot from cell; rows lie across the foot, each cell joined to the next by ports 1 and 4."""
    along = np.asarray(PORT_POINTS_M)[0, :2]
    angle = np.pi / 2 + np.arctan2(along[1], along[0])
    x, y = (np.cos(angle), np.sin(angle), 0.0), (np.sin(angle), -np.cos(angle), 0.0)
    poses = []
    for _, ahead, count in ROWS:
        for place in range(count):
            pose = np.eye(4)
            pose[:3, 0], pose[:3, 1], pose[:3, 2] = x, y, (0.0, 0.0, -1.0)
            # Ports 1 and 4 lie half a pitch to both sides of the cell's middle.
            pose[:3, 3] = ahead, (place - (count - 1) / 2) * 2 * float(np.hypot(*along)), SOLE_Z_M
            poses.append(pose)
    return np.array(poses)
