# SPDX-License-Identifier: Apache-2.0
"""Where links and cells are at a posture of the robot: the frames that other programs are told."""

from __future__ import annotations

from dataclasses import dataclass
from xml.etree import ElementTree

import numpy as np
from numpy.typing import ArrayLike, NDArray
from scipy.spatial.transform import Rotation

from robotskin.layout import Layout
from robotskin.robots import Robot

Floats = NDArray[np.float64]


@dataclass(frozen=True)
class Poses:
    """base_from_cell: (N, 4, 4); translation: (L, 3) metres and rotation: (L, 4) quaternions (x, y, z, w) of each link
    of `PosedSkin.links` in the frame of its parent."""

    base_from_cell: Floats
    translation: Floats
    rotation: Floats


class PosedSkin:
    """Places the N cells of a layout and the links of its robot."""

    def __init__(self, robot: Robot, layout: Layout) -> None:
        names = robot.link_names
        self.base = robot.base_link
        above = {
            joint.find("child").get("link"): joint.find("parent").get("link")  # type: ignore[union-attr]
            for joint in ElementTree.fromstring(robot.urdf).findall("joint")
        }
        self.links = tuple(name for name in names if name in above)
        """All links but the base, a parent before its children."""
        self.parents = tuple(str(above[name]) for name in self.links)
        self._robot = robot
        self._layout = layout
        self._link = np.array([names.index(name) for name in self.links], dtype=int)
        self._parent = np.array([names.index(name) for name in self.parents], dtype=int)
        self._link_of_cell = np.array([names.index(name) for name in layout.links], dtype=int)[layout.link]

    def at(self, position: ArrayLike) -> Poses:
        """The poses at joint positions (n,) rad or m."""
        base_from_link = self._robot.base_from_link(np.asarray(position, dtype=float))
        base_from_cell = base_from_link[self._link_of_cell] @ self._layout.link_from_cell
        parent_from_link = np.linalg.inv(base_from_link[self._parent]) @ base_from_link[self._link]
        rotation = Rotation.from_matrix(parent_from_link[:, :3, :3]).as_quat()
        return Poses(base_from_cell, parent_from_link[:, :3, 3], rotation)
