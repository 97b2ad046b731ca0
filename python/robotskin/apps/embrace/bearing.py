# SPDX-License-Identifier: Apache-2.0
"""What both arms can bear: a thing beyond their torques is refused before it is tried."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from robotskin.apps.embrace.arms import SIDES, Arms, Paths
from robotskin.model import RobotDynamics
from robotskin.session import SessionError
from robotskin.skin import STANDARD_GRAVITY_MPS2

Array = NDArray[np.float64]
FOREARM_THICK_M = 0.055
"""From a forearm's middle to the face of its cells."""
MOST_SHARE = 0.95
"""Of the torque limits that a hold may use."""
SHARE_OF_ARMS = 0.8
"""Of the weight, what the arms bear by friction; the chest bears the rest."""


def torque_shares(arms: Arms, paths: Paths, width_m: float, mass_kg: float, axis_m: float, squeeze_n: float) -> Array:
    """(14,) of the arms' joints, left then right: torque over limit while they hold a thing at the chest.

    A joint bears the arms' own weight and, at the middle of each forearm, half of what the arms bear of the thing's
    weight downward and the squeeze outward: tau = g(q) - J^T f.
    """
    robot = arms.robot
    posture = arms.posture(paths, dict.fromkeys(SIDES, width_m / 2 + FOREARM_THICK_M), axis_m)
    dynamics = RobotDynamics(robot.core)
    dynamics.update(np.ascontiguousarray(posture), np.zeros(robot.joint_count))
    torque = np.array(dynamics.gravity_torque)
    places = robot.base_from_link(posture)
    axis = arms.origin[:2] + np.array([axis_m, 0.0])
    for side in SIDES:
        links = [robot.link_index(f"arm_{side}_{number}_link") for number in (5, 7)]
        middle = places[links][:, :3, 3].mean(axis=0)
        outward = np.append(middle[:2] - axis, 0.0)
        force = squeeze_n * outward / np.linalg.norm(outward)
        force[2] = -SHARE_OF_ARMS * mass_kg * STANDARD_GRAVITY_MPS2 / 2
        jacobian = np.asarray(dynamics.link_jacobian(links[0]))
        arm = middle - places[links[0]][:3, 3]
        at_middle = jacobian[:3] + np.cross(jacobian[3:].T, arm).T
        torque -= at_middle.T @ force
    joints = arms.both
    return np.asarray(np.abs(torque[joints]) / robot.effort_limit[joints])


def require_bearable(arms: Arms, paths: Paths, width_m: float, mass_kg: float, axis_m: float, squeeze_n: float) -> None:
    """Raise SessionError for a thing that the arms cannot hold, naming the joint, its bound and its limit.

    squeeze_n: the largest that the grasp may come to, of one arm.
    """
    shares = torque_shares(arms, paths, width_m, mass_kg, axis_m, squeeze_n)
    worst = int(np.argmax(shares))
    if shares[worst] > MOST_SHARE:
        joint = int(arms.both[worst])
        limit = float(arms.robot.effort_limit[joint])
        raise SessionError(
            f"grasp of {mass_kg:g} kg, {1e3 * width_m:.0f} mm wide, with {squeeze_n:g} N an arm: joint "
            f"{arms.robot.joint_names[joint]} would need {shares[worst] * limit:.1f} Nm, and may give "
            f"{MOST_SHARE * limit:.1f} Nm, {100 * MOST_SHARE:.0f} % of its limit of {limit:.1f} Nm; take a "
            f"lighter or a narrower thing"
        )
