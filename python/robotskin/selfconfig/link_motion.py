"""How links move, turn and feel gravity while one joint swings, from a known kinematic model."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
import pinocchio
from numpy.typing import NDArray

from robotskin.robots import Robot
from robotskin.selfconfig.gravity_samples import GRAVITY_MPS2
from robotskin.selfconfig.joint_sine import JointSine

Array = NDArray[np.float64]


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
        spin = _cross(self.spin)
        return _cross(self.turning) + spin @ spin


def link_motions(robot: Robot, links: Sequence[str], swing: JointSine, time_s: Array) -> dict[str, LinkMotion]:
    """Motions of links, by name, while the robot follows a swing exactly.

    Args:
        robot: whose z axis of the base frame points up.
        links: their names.
        swing: the motion.
        time_s: (M,) since its start.

    Raises:
        UnknownNameError: no such link.
    """
    posture = swing.posture(time_s)
    rate, acceleration = np.zeros_like(posture), np.zeros_like(posture)
    rate[:, swing.joint] = swing.displacement(time_s, 1)
    acceleration[:, swing.joint] = swing.displacement(time_s, 2)
    model, data = robot.model, robot.model.createData()
    frames = [model.getBodyId(robot.link_names[robot.link_index(link)]) for link in links]
    force, spin, turning = (np.empty((len(links), len(time_s), 3)) for _ in range(3))
    up = np.array([0.0, 0.0, GRAVITY_MPS2])
    for instant in range(len(time_s)):
        pinocchio.forwardKinematics(model, data, posture[instant], rate[instant], acceleration[instant])
        for number, frame in enumerate(frames):
            placement = pinocchio.updateFramePlacement(model, data, frame)
            motion = pinocchio.getFrameClassicalAcceleration(model, data, frame, pinocchio.LOCAL)
            force[number, instant] = motion.linear + placement.rotation.T @ up
            turning[number, instant] = motion.angular
            spin[number, instant] = pinocchio.getFrameVelocity(model, data, frame, pinocchio.LOCAL).angular
    return {link: LinkMotion(*of_link) for link, *of_link in zip(links, force, spin, turning, strict=True)}


def _cross(vector: Array) -> Array:
    """(M, 3, 3) with matrix @ w = vector x w."""
    matrix = np.zeros((*vector.shape, 3))
    matrix[..., [2, 0, 1], [1, 2, 0]] = vector
    matrix[..., [1, 2, 0], [2, 0, 1]] = -vector
    return matrix
