# SPDX-License-Identifier: Apache-2.0
"""Where a robot that stands is touched: cells that a hand reaches, and what its motors bear there."""

from __future__ import annotations

from functools import cache

import numpy as np
from numpy.typing import NDArray

from robotskin import robots
from robotskin.layout import Layout, finished
from robotskin.model import RobotDynamics
from robotskin.robots.gains import GainSet
from robotskin.robots.gains.cell_levers import CellLevers, cell_levers
from robotskin_lab.bench.balance_rig import CHEST, ROBOT

Array = NDArray[np.float64]
BORNE_SHARE = 0.5
"""Of a joint's torque, that a touch may ask for at home. As the head gives way the lever of a push on it grows by half;
the rest is for its weight. What is pushed harder gives way at any speed, and no controller holds it."""
FREE_M, WAY_M = 0.1, 0.2
"""No cell of another limb is within the first of a line as long as the second, in front of a cell that a palm nears."""
EMBRACE = "talos_embrace"
"""A layout that the same robot may wear: its chest faces forward in cells, and its wrists have some."""
AHEAD = 0.8
"""Of a chest cell's normal along x, at least."""


@cache
def worn_by_robot(worn: str = ROBOT) -> Layout:
    """A finished layout on the robot that stands; functions below take its name, too."""
    return finished(worn, ROBOT)


def cells_of(link: str, worn: str = ROBOT) -> NDArray[np.int64]:
    """All cells of a link; none where it has no skin."""
    layout = worn_by_robot(worn)
    return np.flatnonzero([layout.links[one] == link for one in layout.link])


def inner_cells(link: str, worn: str = ROBOT) -> NDArray[np.int64]:
    """The cells of a link that have at least three neighbours: a hand reaches them."""
    layout = worn_by_robot(worn)
    if link not in layout.links:
        return np.array([], dtype=int)
    inside = (layout.neighbours[:, :, 0] >= 0).sum(axis=1) >= 3
    return np.flatnonzero((layout.link == layout.links.index(link)) & inside)


def hand_cells(link: str, worn: str = EMBRACE) -> NDArray[np.int64]:
    """The cells of a link that a hand pushes: inner ones, or all of a wrist, which has few."""
    return cells_of(link, worn) if link.endswith("_7_link") else inner_cells(link, worn)


@cache
def home_levers(worn: str = ROBOT) -> CellLevers:
    """Of all cells, of the robot at home."""
    robot = robots.load(ROBOT)
    dynamics = RobotDynamics(robot.core)
    dynamics.update(np.array(GainSet.load(ROBOT).home), np.zeros(robot.joint_count))
    return cell_levers(robot.core, worn_by_robot(worn).skin_model(), dynamics)


def free_cells(link: str, worn: str = ROBOT) -> NDArray[np.int64]:
    """Those of `inner_cells` that a palm reaches along their normal and meets no other limb on its way."""
    layout, levers = worn_by_robot(worn), home_levers(worn)
    limbs = np.array([limb_of(name) for name in layout.links])
    other = levers.point[limbs[layout.link] != limb_of(link)]

    def clearance_m(cell: int) -> float:
        offset, outward = other - levers.point[cell], -levers.inward[cell]
        along = np.clip(offset @ outward, 0.0, WAY_M)
        return float(np.linalg.norm(offset - np.outer(along, outward), axis=1).min())

    return np.array([cell for cell in inner_cells(link, worn) if clearance_m(cell) > FREE_M], dtype=int)


def chest_cells(worn: str = EMBRACE) -> NDArray[np.int64]:
    """Those of `free_cells` of the chest that face forward."""
    cells = free_cells(CHEST, worn)
    return cells[-home_levers(worn).inward[cells, 0] > AHEAD]


def limb_of(link: str) -> str:
    """Such as arm_left of arm_left_5_link."""
    return link.rsplit("_", 2)[0]


@cache
def borne_n() -> Array:
    """(N) newton on each cell, against its normal, that ask for `BORNE_SHARE` of some joint's torque; infinite where
    it moves no joint.
    """
    limit = np.asarray(robots.load(ROBOT).effort_limit)
    driven = limit > 0
    with np.errstate(divide="ignore"):
        return np.asarray(BORNE_SHARE * (limit[driven] / np.abs(home_levers().torque[:, driven])).min(axis=1))
