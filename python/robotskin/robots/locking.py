# SPDX-License-Identifier: Apache-2.0
"""Joints that are held in one position for good: the fingers of a gripper, wheels, a lift."""

from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING
from xml.etree import ElementTree

import numpy as np
import pinocchio
from scipy.spatial.transform import Rotation

from robotskin.errors import InputError, UnknownNameError

if TYPE_CHECKING:
    from robotskin.robots.robot import Robot


def lock(root: ElementTree.Element, positions: Mapping[str, float]) -> None:
    """Make joints of a URDF fixed, in place.

    Args:
        root: the `<robot>` element.
        positions: rad or m by name of the joint.

    Raises:
        UnknownNameError: no such movable joint. InputError: none would be left, or a position that is no number.
    """
    movable = {joint.get("name", ""): joint for joint in root.findall("joint") if joint.get("type") != "fixed"}
    for name, position in positions.items():
        if name not in movable:
            raise UnknownNameError(f"movable joint of {root.get('name')}", name, movable)
        if not np.isfinite(position):
            raise InputError(f"locked joint {name} at {position}: must be a finite number")
    if movable and not set(movable) - set(positions):
        raise InputError(f"all {len(movable)} joints of {root.get('name')} are to be locked: leave at least one")
    for name, position in positions.items():
        _fix(movable[name], float(position))


def _fix(joint: ElementTree.Element, position: float) -> None:
    origin = joint.find("origin")
    if origin is None:
        origin = ElementTree.SubElement(joint, "origin")
    place = np.array([float(word) for word in origin.get("xyz", "0 0 0").split()])
    turn = Rotation.from_euler("xyz", [float(word) for word in origin.get("rpy", "0 0 0").split()])
    axis_element = joint.find("axis")
    text = "1 0 0" if axis_element is None else axis_element.get("xyz", "1 0 0")
    axis = np.array([float(word) for word in text.split()])
    axis = axis / np.linalg.norm(axis)
    if joint.get("type") == "prismatic":
        place = place + turn.apply(axis * position)
    else:
        turn = turn * Rotation.from_rotvec(axis * position)
    origin.set("xyz", " ".join(repr(float(value)) for value in place))
    origin.set("rpy", " ".join(repr(float(value)) for value in pinocchio.rpy.matrixToRpy(turn.as_matrix())))
    joint.set("type", "fixed")
    for tag in ("axis", "limit", "dynamics", "mimic", "calibration", "safety_controller"):
        for element in joint.findall(tag):
            joint.remove(element)


def joints_to_lock(robot: Robot) -> dict[str, float]:
    """Joints that a skin has no use for, with where to hold them: coupled ones, such as a gripper's, and wheels.

    Coupled joints are those that follow another one and the one that they follow. A wheel turns without end, hangs on
    the base by joints without end alone, and carries none with an end. A robot of nothing else keeps all its joints.
    """
    coupled = {name for mimic in robot.mimics for name in (mimic.joint, mimic.source)}
    found = coupled | _wheels(robot)
    if len(found) == robot.joint_count:
        return {}
    inside = inside_limits(robot)
    return {name: float(inside[index]) for index, name in enumerate(robot.joint_names) if name in found}


def inside_limits(robot: Robot, share: float = 0.1, most: float = 0.3) -> np.ndarray:
    """(n) rad or m: the neutral posture, moved `share` of each joint's range, at most `most`, inside its limits."""
    room = np.minimum(most, share * (robot.upper - robot.lower))
    room = np.where(np.isfinite(room), room, 0.0)
    return np.clip(np.zeros(robot.joint_count), robot.lower + room, robot.upper - room)


def _wheels(robot: Robot) -> set[str]:
    # A joint without limits, or with the whole turns that stand for them.
    endless = ~np.isfinite(robot.upper) | (robot.upper - robot.lower > 4 * np.pi + 1)
    parent = [int(joint) - 1 for joint in robot.model.parents[1:]]
    path_endless = endless.copy()
    tree_endless = endless.copy()
    for joint, above in enumerate(parent):
        if above >= 0:
            path_endless[joint] &= path_endless[above]
    for joint in reversed(range(robot.joint_count)):
        if parent[joint] >= 0:
            tree_endless[parent[joint]] &= tree_endless[joint]
    return {name for index, name in enumerate(robot.joint_names) if path_endless[index] and tree_endless[index]}
