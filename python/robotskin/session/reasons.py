# SPDX-License-Identifier: Apache-2.0
"""Why a robot did not do as it was asked: which limit of which joint held its commands back, and what a goal lacks."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from robotskin.cycle import Limit
from robotskin.robots import Robot

SHOWN = 3
AT_LIMIT_RAD = 0.03
"""The guard keeps commands 0.02 rad inside the limits."""

IN_WORDS = {
    Limit.position: "position limit",
    Limit.velocity: "velocity limit",
    Limit.acceleration: "acceleration limit of the gains",
    Limit.torque: "torque limit",
    Limit.torque_rate: "torque rate of the gains",
}


def interventions_told(counts: NDArray[np.uint64], joints: Sequence[str]) -> str:
    """The limits that changed commands most, such as "velocity limit of elbow in 12 ticks"; empty where none did.

    counts: (5, n) ticks by limit and joint, as the cycle's `intervention_counts`.
    """
    found = [(int(counts[limit, joint]), limit, joint) for limit, joint in zip(*np.nonzero(counts), strict=True)]
    found.sort(key=lambda entry: (-entry[0], entry[1], entry[2]))
    told = [
        f"{IN_WORDS[Limit(int(limit))]} of {joints[joint]} in {ticks} {'tick' if ticks == 1 else 'ticks'}"
        for ticks, limit, joint in found[:SHOWN]
    ]
    more = f", and {len(found) - SHOWN} more" if len(found) > SHOWN else ""
    return ", ".join(told) + more


def missed_goal_told(robot: Robot, position: NDArray[np.float64], error: float, unit: str, moving: bool) -> str:
    """Why a goal was missed: the robot is still on its way, or joints stand at their limits, or neither is the case.

    Args:
        robot: of n joints.
        position: (n) rad or m where it stands.
        error: how far from the goal, in `unit`.
        unit: "rad" or "m".
        moving: whether the reference has not arrived yet.
    """
    missed = f"the goal was missed by {error:.3g} {unit}"
    if moving:
        return f"{missed}: it is still on its way; give it more time (--seconds) or more speed (gains)"
    room = np.minimum(position - robot.lower, robot.upper - position)
    ends = [
        f"{robot.joint_names[joint]} at {position[joint]:.3f} of {robot.lower[joint]:.3f} to {robot.upper[joint]:.3f}"
        for joint in np.flatnonzero(room < AT_LIMIT_RAD)
    ]
    if ends:
        return f"{missed}: at its limit is {', '.join(ends)}"
    return f"{missed}: no joint is at a limit; touch, friction or a soft gain held it"
