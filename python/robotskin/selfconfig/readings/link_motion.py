# SPDX-License-Identifier: Apache-2.0
"""How links move, turn and feel gravity while one joint swings, from a known kinematic model."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
import pinocchio
from numpy.typing import NDArray
from scipy.interpolate import make_lsq_spline
from scipy.spatial.transform import Rotation

from robotskin.model import RobotDynamics
from robotskin.robots import Robot
from robotskin.selfconfig.babbling.joint_sine import JointSine
from robotskin.selfconfig.common.gravity import GRAVITY_MPS2
from robotskin.selfconfig.common.rotations import cross_matrix

Array = NDArray[np.float64]

KNOT_PERIODS, DEGREE = 0.2, 5
"""Of the splines through what joints did beside a swing: what answers it is followed, and faster noise left out."""


@dataclass(frozen=True, eq=False)
class LinkMotion:
    """What M instants do to one link; all in its own frame.

    specific_force: (M, 3) m/s² of the link's origin, gravity's reaction included, as an accelerometer there reads it.
    spin: (M, 3) rad/s, angular velocity; turning: (M, 3) rad/s², angular acceleration.
    """

    specific_force: Array
    spin: Array
    turning: Array

    def tidal(self) -> Array:
        """(M, 3, 3) 1/s²: a point p of the link feels specific_force + tidal @ p, with tidal = [α]× + [ω]×[ω]×."""
        spin = cross_matrix(self.spin)
        return cross_matrix(self.turning) + spin @ spin


def link_motions(
    robot: Robot, links: Sequence[str], swing: JointSine, time_s: Array, posture: Array | None = None
) -> dict[str, LinkMotion]:
    """Motions of links, by name, while the robot follows a swing exactly.

    Args:
        robot: whose z axis of the base frame points up.
        links: their names.
        swing: the motion.
        time_s: (M,) since its start.
        posture: (M, n) rad or m, measured then, of which all but the swung joint count; None: these stay.

    Raises:
        UnknownNameError: no such link.
    """
    if posture is not None:
        return _carried(robot, links, swing, time_s, posture)
    dynamics, moved = _at_centre(robot, swing), _moved_by(robot, swing.joint)
    linear, axis = np.split(dynamics.joint_motions[swing.joint], 2)
    angle, rate, turn_rate = (swing.displacement(time_s, derivative) for derivative in range(3))
    up, motions = np.array([0.0, 0.0, GRAVITY_MPS2]), {}
    for link in links:
        index = robot.link_index(link)
        pose = dynamics.base_from_link(index)
        still = np.zeros((len(time_s), 3))
        felt, own_axis = still + pose[:3, :3].T @ up, pose[:3, :3].T @ axis
        if not moved[index]:
            motions[link] = LinkMotion(felt, still, still)
        elif not axis.any():
            motions[link] = LinkMotion(felt + turn_rate[:, None] * (pose[:3, :3].T @ linear), still, still)
        else:
            # The axis stands still in the base and in the link; in the link's frame gravity turns backwards about it.
            arm = pose[:3, :3].T @ (pose[:3, 3] - np.cross(axis, linear))
            gravity = Rotation.from_rotvec(-angle[:, None] * own_axis).apply(pose[:3, :3].T @ up)
            tangential, centripetal = np.cross(own_axis, arm), np.cross(own_axis, np.cross(own_axis, arm))
            force = gravity + turn_rate[:, None] * tangential + rate[:, None] ** 2 * centripetal
            motions[link] = LinkMotion(force, rate[:, None] * own_axis, turn_rate[:, None] * own_axis)
    return motions


def link_gravity(robot: Robot, links: Sequence[str], swing: JointSine, time_s: Array) -> dict[str, Array]:
    """(M, 3) m/s² of each link, in its own frame: gravity's part of its specific force during a swing.

    Args:
        robot: whose z axis of the base frame points up.
        links: their names.
        swing: the motion.
        time_s: (M,) since its start.
    """
    dynamics, moved = _at_centre(robot, swing), _moved_by(robot, swing.joint)
    axis = dynamics.joint_motions[swing.joint, 3:]
    turn = -swing.displacement(time_s)[:, None]
    found = {}
    for link in links:
        rotation = dynamics.base_from_link(robot.link_index(link))[:3, :3]
        up = rotation.T @ np.array([0.0, 0.0, GRAVITY_MPS2])
        found[link] = (
            Rotation.from_rotvec(turn * (rotation.T @ axis)).apply(up)
            if moved[robot.link_index(link)]
            else np.tile(up, (len(time_s), 1))
        )
    return found


def _carried(
    robot: Robot, links: Sequence[str], swing: JointSine, time_s: Array, posture: Array
) -> dict[str, LinkMotion]:
    """Motions of links while all joints move: one by the swing, the others smoothly by what was measured (M, n)."""
    knot_s = KNOT_PERIODS / swing.frequency_hz
    inner = np.arange(time_s[0] + knot_s, time_s[-1] - knot_s / 2, knot_s)
    knots = np.r_[[time_s[0]] * (DEGREE + 1), inner, [time_s[-1]] * (DEGREE + 1)]
    spline = make_lsq_spline(time_s, posture, knots, k=DEGREE)
    moved = [np.asarray(spline(time_s, derivative), dtype=float) for derivative in range(3)]
    for derivative, values in enumerate(moved):
        values[:, swing.joint] = swing.displacement(time_s, derivative)
    moved[0][:, swing.joint] += swing.centre[swing.joint]
    model, data = robot.model, robot.model.createData()
    frames = [model.getFrameId(robot.link_names[robot.link_index(link)]) for link in links]
    up = np.array([0.0, 0.0, GRAVITY_MPS2])
    found = np.empty((len(links), 3, len(time_s), 3))
    for instant, (q, v, a) in enumerate(zip(*moved, strict=True)):
        pinocchio.forwardKinematics(model, data, q, v, a)
        for each, frame in zip(found, frames, strict=True):
            pose = pinocchio.updateFramePlacement(model, data, frame)
            classical = pinocchio.getFrameClassicalAcceleration(model, data, frame, pinocchio.LOCAL)
            each[0, instant] = classical.linear + pose.rotation.T @ up
            each[1, instant] = pinocchio.getFrameVelocity(model, data, frame, pinocchio.LOCAL).angular
            each[2, instant] = classical.angular
    return {link: LinkMotion(*each) for link, each in zip(links, found, strict=True)}


def _at_centre(robot: Robot, swing: JointSine) -> RobotDynamics:
    """The robot at rest in a swing's centre."""
    dynamics = RobotDynamics(robot.core)
    centre = np.ascontiguousarray(swing.centre, dtype=float)
    dynamics.update(centre, np.zeros_like(centre))
    return dynamics


def _moved_by(robot: Robot, joint: int) -> list[bool]:
    """(l) whether a joint moves each link."""
    parents = robot.core.joint_parents
    found = []
    for carrier in robot.core.link_joints:
        above = int(carrier)
        while above > joint:
            above = int(parents[above])
        found.append(above == joint)
    return found
