# SPDX-License-Identifier: Apache-2.0
"""The skinned parallel gripper of a robot: its joints, the cells of its pads, and what they feel."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from robotskin.errors import RobotskinError
from robotskin.layout import Layout
from robotskin.robots import Robot
from robotskin.session import SkinnedRobot

Array = NDArray[np.float64]

PADS = ("left_pad", "right_pad")
HAND = "gripper"
"""The link that carries the pads."""


class TeachingError(RobotskinError):
    """What cannot be taught, planned or carried out; the message names the step and what is missing."""


class Gripper:
    """The gripper of a robot in its skin; n joints, N cells.

    Raises:
        TeachingError: a robot without the two pads, or a skin without a cell on one of them.
    """

    def __init__(self, robot: Robot, layout: Layout) -> None:
        for pad in PADS:
            if f"{pad}_joint" not in robot.joint_names:
                raise TeachingError(
                    f"gripper of {robot.name}: it has no joint {pad}_joint; use ur5_gripper or panda_gripper"
                )
        self.robot = robot
        self.joints = np.array([robot.joint_index(f"{pad}_joint") for pad in PADS])
        """(2,) left, right: the distance of each pad's skin from the middle, m."""
        self.arm = np.setdiff1d(np.arange(robot.joint_count), self.joints)
        """Indices of the other joints."""
        names = [layout.links[link] for link in layout.link]
        self.cells = [np.array([i for i, name in enumerate(names) if name == pad], dtype=int) for pad in PADS]
        """Of each pad, the indices of its cells."""
        for pad, cells in zip(PADS, self.cells, strict=True):
            if not len(cells):
                raise TeachingError(
                    f"gripper in this layout of {layout.robot}: no cell on {pad}, which has to feel what it holds; use "
                    f"the layout that comes with {robot.name}"
                )
        self.patches = sorted({int(layout.patch[cell]) for cells in self.cells for cell in cells})
        """Whose cells feel things, not people."""
        self.button = self._button(layout, names)
        """Indices of the cells that take taps: those of the smallest patch on the arm's last links."""
        zero = robot.neutral.copy()
        placed = robot.base_from_link(zero)
        middle = np.mean([placed[robot.link_index(pad)][:3, 3] for pad in PADS], axis=0)
        self.hand_from_middle: Array = np.linalg.inv(placed[robot.link_index(HAND)]) @ [*middle, 1.0]
        """(4,) the point between the pads in the frame of the hand, m."""
        self.most_open_m = float(robot.upper[self.joints].min())

    def _button(self, layout: Layout, names: list[str]) -> NDArray[np.int64]:
        order = self.robot.link_names
        on_arm = [cell for cell, name in enumerate(names) if name not in PADS]
        if not on_arm:
            return np.zeros(0, dtype=int)
        links = sorted({names[cell] for cell in on_arm}, key=order.index)[-2:]
        link = min(links, key=lambda name: names.count(name))
        return np.array([cell for cell in on_arm if names[cell] == link], dtype=int)

    def forces_n(self, session: SkinnedRobot) -> Array:
        """(2,) newton that each pad feels."""
        force = session.cell_forces_n()
        return np.array([force[cells].sum() for cells in self.cells])

    def nearness(self, session: SkinnedRobot) -> Array:
        """(2,) 0 to 1, the nearest thing that each pad sees."""
        near = session.cell_nearness()
        return np.array([near[cells].max() for cells in self.cells])

    def opening_m(self, session: SkinnedRobot) -> Array:
        """(2,) metres, of each pad from the middle."""
        return np.array(session.joints.position)[self.joints]
