# SPDX-License-Identifier: Apache-2.0
"""What holds a standing robot up, and what touches it: as the controller, its foot sensors and the skin tell it."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from robotskin.control import FEEDFORWARD
from robotskin.layout import Layout
from robotskin.session import SkinnedRobot

Array = NDArray[np.float64]
FELT_N = 0.3
"""A cell that feels less is not touched."""


@dataclass(frozen=True)
class Held:
    """What holds a standing robot up at one moment; world frame, SI units."""

    centre: Array
    """(3,) centre of mass."""
    capture: Array
    """(2,) capture point."""
    zmp: Array | None
    """(2,) zero-moment point; None where a foot does not tell its force."""
    corners: Array
    """(K, 2) of the support polygon."""
    inside_m: float
    """How far the capture point is inside of the polygon."""
    pressed: Array
    """(2, 2) where each foot presses; means nothing without its force."""
    force: Array | None
    """(2, 3) N of the floor on each foot; None where a foot does not tell its force."""
    moment: Array | None
    """(2, 3) Nm of the floor on each foot, about the middle of its sole; None with `force`."""


@dataclass(frozen=True)
class Touched:
    """All that touches one link, world frame: `place` (3,) m, the middle of the touches; `force` (3,) N, their sum."""

    link: str
    place: Array
    force: Array


def held(session: SkinnedRobot) -> Held | None:
    """What the controller knows now; None before its first tick, and of a robot that does not stand."""
    state = session.controller.cycle.standing
    if state is None or len(state.support.corners) < 3:
        return None
    force = moment = None
    if state.forces_count:
        force, moment = foot_wrenches(session)
    return Held(
        np.array(state.centre_of_mass),
        np.array(state.capture_point),
        np.array(state.zmp) if state.forces_count else None,
        np.array(state.support.corners),
        float(state.support.inside_by(state.capture_point)),
        np.array(state.foot_place) + np.array(state.foot_pressure),
        force,
        moment,
    )


def foot_wrenches(session: SkinnedRobot) -> tuple[Array, Array]:
    """(2, 3) N and (2, 3) Nm, world frame, of the floor on each foot; the moment about the middle of the sole."""
    robot = session.robot
    assert robot.standing is not None
    world_from_link = np.asarray(robot.base_from_link(np.array(session.joints.position)))
    by_link = dict(zip([place.link for place in session.port.sensors.forces], session.loop.sensors.forces, strict=True))
    force, moment = np.empty((2, 3)), np.empty((2, 3))
    for index, foot in enumerate(robot.standing.feet):
        turn = world_from_link[robot.link_index(foot.link), :3, :3]
        told = by_link[foot.link]
        force[index] = turn @ np.array(told.force)
        # The sensor tells the moment about the origin of the foot's link.
        moment[index] = turn @ (np.array(told.moment) - np.cross(foot.sole_m, told.force))
    return force, moment


def touched(layout: Layout, world_from_cell: NDArray[np.floating], force_n: NDArray[np.floating]) -> list[Touched]:
    """The links that are touched, the hardest pressed first.

    Args:
        layout: N cells.
        world_from_cell: (N, 4, 4) m.
        force_n: (N,) N that each cell feels; below `FELT_N` it is not touched.
    """
    force_n = np.where(np.asarray(force_n) > FELT_N, force_n, 0.0)
    found = []
    for link in np.unique(layout.link[force_n > 0]):
        cells = np.flatnonzero((layout.link == link) & (force_n > 0))
        newton, pose = force_n[cells], world_from_cell[cells]
        place = newton @ pose[:, :3, 3] / newton.sum()
        found.append(Touched(layout.links[link], place, -newton @ pose[:, :3, 2]))
    return sorted(found, key=lambda one: -float(np.linalg.norm(one.force)))


def priorities(session: SkinnedRobot) -> list[tuple[str, str]]:
    """(level, tasks) of the behaviour, the highest first; what is added without a level last."""
    by_level: dict[int, list[str]] = {}
    for name, level in session.controller.behaviour.tasks.items():
        by_level.setdefault(level, []).append(name.replace("_", " "))
    levels = sorted(level for level in by_level if level != FEEDFORWARD)
    rows = [(str(level), ", ".join(by_level[level])) for level in levels]
    if FEEDFORWARD in by_level:
        rows.append(("+", ", ".join(by_level[FEEDFORWARD])))
    return rows
