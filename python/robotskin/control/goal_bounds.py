# SPDX-License-Identifier: Apache-2.0
"""Goals that a robot is not given: no posture reaches them, or a robot on feet would not stand in them."""

from __future__ import annotations

from collections.abc import Collection, Iterable
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray

from robotskin.errors import InputError
from robotskin.model import RobotDynamics, RobotModel
from robotskin.robots.reach import nearest_to
from robotskin.robots.standing import BASE_JOINTS, feet_of
from robotskin.tasks import SupportPolygon

Array = NDArray[np.float64]

OUT_OF_REACH_M = 0.005
LEAST_INSIDE_M = 0.03
"""By which the centre of mass of a goal lies inside of the soles of a robot that stands."""
MOST_APART_M, MOST_TILT_RAD = 0.01, 0.05
"""Of the soles in a goal, from one level floor."""


@dataclass(frozen=True)
class Wanted:
    """One reference that a goal asks for: (n) rad or m of the joints, or (4, 4) metres of a link.

    joints: those that it moves, by name; empty: all. The others stay where they are.
    """

    reference: Array
    link: str = ""
    joints: tuple[str, ...] = ()


def require_stands(robot: RobotModel, wanted: Iterable[Wanted], present: ArrayLike) -> None:
    """Refuse references that together a robot on feet cannot follow and stand; a mounted robot takes any.

    present: (n) rad or m, where its joints are. Raises InputError, which names the bound.
    """
    if not feet_of(robot):
        return
    posture = np.array(present, dtype=float)
    names = list(robot.joint_names)
    # Links last: the joints that others ask for carry them.
    for one in sorted(wanted, key=lambda each: each.reference.ndim):
        if one.reference.ndim == 2:
            posture = require_reach(robot, one.link, one.reference[:3, 3], posture, one.joints)
            continue
        if len(one.reference) != len(names):
            raise InputError(f"joint goal of {len(one.reference)} numbers: {robot.name} has {len(names)} joints")
        moved = [names.index(joint) for joint in one.joints] or list(range(len(names)))
        posture[moved] = one.reference[moved]
    require_balance(robot, posture)


def require_reach(
    robot: RobotModel, link: str, point_m: Array, present: ArrayLike, joints: Collection[str] = ()
) -> Array:
    """The posture (n) in which a link is at a point, one in balance where there is such.

    Args:
        robot: n joints; the base of one on feet stays where it is.
        link: its name, of the origin that is brought there.
        point_m: (3) base frame.
        present: (n) rad or m, where its joints are.
        joints: those that may move, by name; by default all.

    Raises:
        InputError: no posture reaches it, or those found for a robot on feet are beyond balance; with the bound.
    """
    posture, left = nearest_to(
        robot, link, point_m, np.asarray(present), joints, lambda found: not balance_refused(robot, found)
    )
    at = f"goal at {', '.join(f'{value:.3f}' for value in point_m)} m: "
    if left > OUT_OF_REACH_M:
        room = np.minimum(posture - robot.lower, robot.upper - posture)
        ends = [
            name
            for name, left_over in zip(robot.joint_names, room, strict=True)
            if left_over < 1e-6 and (not joints or name in joints)
        ]
        why = f" with {', '.join(ends)} at the limit" if ends else ", stretched out"
        raise InputError(f"{at}out of reach, {link} comes no nearer than {left:.3f} m{why}")
    refused = balance_refused(robot, posture)
    if refused:
        raise InputError(f"{at}{refused}")
    return posture


def require_balance(robot: RobotModel, posture: Array) -> None:
    """Refuse a goal (n) in which a robot on feet would not stand; a robot that is mounted takes any.

    Raises InputError, which names the bound: soles on one level floor, centre of mass inside by `LEAST_INSIDE_M`.
    """
    refused = balance_refused(robot, posture)
    if refused:
        raise InputError(f"goal: {refused}")


def balance_refused(robot: RobotModel, posture: Array) -> str:
    """Why a robot would not stand in a posture (n) rad or m; empty where it would, and for one that is mounted."""
    feet = feet_of(robot)
    if not feet:
        return ""
    posture = np.array(posture, dtype=float)
    # Where the base is to be is not the goal's to say: the first sole tells where the floor is.
    posture[[list(robot.joint_names).index(joint) for joint in BASE_JOINTS]] = 0.0
    dynamics = RobotDynamics(robot)
    dynamics.update(posture, np.zeros(len(posture)))
    poses = [dynamics.base_from_link(robot.link_index(foot.link)) for foot in feet]
    floor_from_base = np.linalg.inv(poses[0] @ _lifted(feet[0].sole))
    soles = [floor_from_base @ pose @ _lifted(foot.sole) for pose, foot in zip(poses, feet, strict=True)]
    apart = abs(float(soles[1][2, 3]))
    tilt = float(np.arccos(np.clip(soles[1][2, 2], -1.0, 1.0)))
    if apart > MOST_APART_M or tilt > MOST_TILT_RAD:
        return (
            f"the soles would be {1e3 * apart:.0f} mm and {np.degrees(tilt):.1f} degrees from one level floor; "
            f"at most {1e3 * MOST_APART_M:g} mm and {np.degrees(MOST_TILT_RAD):.0f} degrees"
        )
    polygon = SupportPolygon()
    signs = ((1, 1), (1, -1), (-1, -1), (-1, 1))
    polygon.set(
        [
            tuple((pose @ [sx * foot.half[0], sy * foot.half[1], 0.0, 1.0])[:2])
            for pose, foot in zip(soles, feet, strict=True)
            for sx, sy in signs
        ]
    )
    centre = floor_from_base @ np.append(dynamics.centre_of_mass, 1.0)
    inside = polygon.inside_by((float(centre[0]), float(centre[1])))
    if inside >= LEAST_INSIDE_M:
        return ""
    where = f"{1e3 * inside:.0f} mm inside of" if inside > 0 else f"{-1e3 * inside:.0f} mm outside of"
    return f"the centre of mass would be {where} the soles; it has to be {1e3 * LEAST_INSIDE_M:g} mm inside"


def _lifted(point: ArrayLike) -> Array:
    """(4, 4) of a frame that is only moved."""
    result = np.eye(4)
    result[:3, 3] = point
    return result
