# SPDX-License-Identifier: Apache-2.0
"""Where a robot that stands is touched: cells that a hand reaches, and what its motors bear there."""

from __future__ import annotations

from functools import cache

import numpy as np
from numpy.typing import NDArray

from robotskin import robots
from robotskin.layout import finished
from robotskin.model import RobotDynamics
from robotskin.robots.gains import GainSet
from robotskin_lab.bench.balance_rig import ROBOT

Array = NDArray[np.float64]
BORNE_SHARE = 0.5
"""Of a joint's torque, that a touch may ask for at home. As the head gives way the lever of a push on it grows by half;
the rest is for its weight. What is pushed harder gives way at any speed, and no controller holds it."""
FREE_M, WAY_M = 0.1, 0.2
"""No cell of another limb is within the first of a line as long as the second, in front of a cell that a palm nears."""


def inner_cells(link: str) -> NDArray[np.int64]:
    """The cells of a link that have at least three neighbours: a hand reaches them."""
    layout = finished(ROBOT)
    if link not in layout.links:
        return np.array([], dtype=int)
    inside = (layout.neighbours[:, :, 0] >= 0).sum(axis=1) >= 3
    return np.flatnonzero((layout.link == layout.links.index(link)) & inside)


@cache
def home_cells() -> Array:
    """(N, 4, 4) the frames of all cells in the world, of the robot at home."""
    robot, layout = robots.load(ROBOT), finished(ROBOT)
    links = np.array([robot.link_index(name) for name in layout.links])
    return np.asarray(robot.base_from_link(GainSet.load(ROBOT).home)[links[layout.link]] @ layout.link_from_cell)


def free_cells(link: str) -> NDArray[np.int64]:
    """Those of `inner_cells` that a palm reaches along their normal and meets no other limb on its way."""
    layout, places = finished(ROBOT), home_cells()
    limbs = np.array([limb_of(name) for name in layout.links])
    other = places[limbs[layout.link] != limb_of(link), :3, 3]

    def clearance_m(cell: int) -> float:
        offset = other - places[cell, :3, 3]
        along = np.clip(offset @ places[cell, :3, 2], 0.0, WAY_M)
        return float(np.linalg.norm(offset - np.outer(along, places[cell, :3, 2]), axis=1).min())

    return np.array([cell for cell in inner_cells(link) if clearance_m(cell) > FREE_M], dtype=int)


def limb_of(link: str) -> str:
    """Such as arm_left of arm_left_5_link."""
    return link.rsplit("_", 2)[0]


@cache
def borne_n() -> Array:
    """(N) newton on each cell, against its normal, that ask for `BORNE_SHARE` of some joint's torque; infinite where
    it moves no joint.
    """
    robot, layout, places = robots.load(ROBOT), finished(ROBOT), home_cells()
    dynamics = RobotDynamics(robot.core)
    dynamics.update(np.array(GainSet.load(ROBOT).home), np.zeros(robot.joint_count))
    driven = np.asarray(robot.effort_limit) > 0
    found = np.empty(len(layout))
    for link in range(len(layout.links)):
        index, cells = robot.link_index(layout.links[link]), np.flatnonzero(layout.link == link)
        jacobian = np.array(dynamics.link_jacobian(index))[:, driven]
        force = -places[cells, :3, 2]
        lever = places[cells, :3, 3] - np.array(dynamics.base_from_link(index))[:3, 3]
        torque = np.abs(force @ jacobian[:3] + np.cross(lever, force) @ jacobian[3:])
        with np.errstate(divide="ignore"):
            found[cells] = BORNE_SHARE * (np.asarray(robot.effort_limit)[driven] / torque).min(axis=1)
    return found
