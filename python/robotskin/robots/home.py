# SPDX-License-Identifier: Apache-2.0
"""A posture to stand in, for a robot that has been given none, and the link that is its hand."""

from __future__ import annotations

from typing import TYPE_CHECKING
from xml.etree import ElementTree

import numpy as np
from numpy.typing import NDArray

from robotskin.model import RobotDynamics
from robotskin.robots.free_space import FreeSpace
from robotskin.robots.locking import inside_limits
from robotskin.robots.urdf_tree import link_of

if TYPE_CHECKING:
    from robotskin.robots.robot import Robot

Array = NDArray[np.float64]

ARM_JOINTS = 9
"""Up to so many joints a robot is taken for one arm, whose home is searched for."""
CANDIDATES = 400
SPREAD_RAD = 1.6


def found_home(robot: Robot) -> Array:
    """(n) rad or m: a posture inside the limits, clear of the robot itself, with its hand free to move.

    An arm's is searched for: above its base, little torque to hold it, a hand that can move in all directions, close to
    neutral. A robot with more joints stands near neutral, its joints a little inside their limits. Each time the same.
    """
    space = FreeSpace(robot)
    middle = inside_limits(robot)
    if robot.joint_count > ARM_JOINTS:
        return space.nearest_free(middle)
    room = np.minimum(0.3, 0.15 * (robot.upper - robot.lower))
    lower, upper = robot.lower + room, robot.upper - room
    random = np.random.default_rng(0)
    drawn = np.clip(middle + random.uniform(-SPREAD_RAD, SPREAD_RAD, (CANDIDATES, len(middle))), lower, upper)
    link = robot.link_index(hand_link(robot))
    cost = np.array([_cost(robot, link, q, middle) for q in drawn])
    for index in np.argsort(cost):
        if space.is_free(drawn[index]):
            return np.round(drawn[index], 3)
    return space.nearest_free(middle)


def _cost(robot: Robot, link: int, q: Array, middle: Array) -> float:
    dynamics = RobotDynamics(robot.core)
    dynamics.update(np.ascontiguousarray(q), np.zeros(len(q)))
    load = np.abs(np.array(dynamics.nonlinear_effects)) / np.maximum(robot.effort_limit, 1e-3)
    values = np.linalg.svd(dynamics.link_jacobian(link)[:3], compute_uv=False)
    below = -min(0.0, float(robot.base_from_link(q)[:, 2, 3].min()))
    free = float(values[-1] / values[0]) if len(q) >= 3 and values[0] > 0 else 0.0
    return float(load.max() + 0.5 * load.sum() - free + 0.1 * np.abs(q - middle).sum() + 10.0 * below)


def hand_link(robot: Robot) -> str:
    """The link at the end of the longest chain of joints; of a hand with several fingers, its palm."""
    core = robot.core
    joints = np.asarray(core.link_joints)
    depth = np.zeros(robot.joint_count, dtype=int)
    parent = [int(joint) - 1 for joint in robot.model.parents[1:]]
    for joint, above in enumerate(parent):
        depth[joint] = 1 + (depth[above] if above >= 0 else 0)
    end = int(np.argmax(depth))
    # Fingers that branch off one joint are parts of the hand; a limb of more than four joints is none.
    above = parent[end]
    length = 1
    while above >= 0 and length <= 4:
        if parent.count(above) > 1:
            end, length = above, 0
        above, length = parent[above], length + 1
    held = _held_links(robot)
    links = [core.link_names[index] for index, joint in enumerate(joints) if joint == end]
    surfaces = robot.links_with("collision")
    shown = [link for link in links if link in surfaces and link not in held]
    return str((shown or links)[-1])


def _held_links(robot: Robot) -> set[str]:
    """Links behind joints that are locked: fingers are no hand."""
    joints = ElementTree.fromstring(robot.urdf).findall("joint")
    ends = [(joint.get("name", ""), link_of(joint, "parent"), link_of(joint, "child")) for joint in joints]
    held = {child for name, _, child in ends if name in robot.locked}
    while more := {child for _, parent, child in ends if parent in held and child not in held}:
        held |= more
    return held
