# SPDX-License-Identifier: Apache-2.0
"""What speaks against gains that were written by hand: contacts that do not settle, speeds that no joint has."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from robotskin.robots.gains.gain_set import GainSet
from robotskin.robots.gains.made import PUSH_N, SETTLED_N_M, Body
from robotskin.robots.gains.stability import Loop
from robotskin.robots.robot import Robot

Array = NDArray[np.float64]

SOFTER = 2.0
SOFTEST_N_M = 100.0
MOST_OF_SPEED = 1.0
"""Share of a joint's speed that a touch may ask for; made gains ask for two fifths."""


def doubts(robot: Robot, gains: GainSet) -> list[str]:
    """A sentence for each doubt about gains that fit the robot; none where there is none.

    Looked at: the loop in contact, linear about home (`stability.py`), and how fast a touch of `PUSH_N` with all its
    proximity turns the joints.
    """
    body = Body(robot, np.asarray(gains.home, dtype=float))
    loop = body.loop(gains)
    found = []
    if not loop.settles(SETTLED_N_M):
        bearable = SETTLED_N_M
        while bearable >= SOFTEST_N_M and not loop.settles(bearable):
            bearable /= SOFTER
        told = f"contacts settle up to {bearable:.0f} N/m only" if bearable >= SOFTEST_N_M else "no contact settles"
        found.append(
            f"{told}, made gains bear {SETTLED_N_M:.0f}: raise virtual_robot.friction_s or lower "
            "skin.compliance_m_per_n"
        )
    asked = speed_share(loop, gains, robot.velocity_limit)
    worst = int(np.argmax(asked))
    if asked[worst] > MOST_OF_SPEED:
        found.append(
            f"a touch of {PUSH_N:g} N asks {robot.joint_names[worst]} for {asked[worst]:.0%} of its greatest speed: "
            "lower skin.largest_give_rad_per_n or skin.compliance_m_per_n, or raise virtual_robot.friction_s"
        )
    return found


def speed_share(loop: Loop, gains: GainSet, velocity_limit: Array) -> Array:
    """(n,) the speed that a touch of `PUSH_N` with all its proximity asks of each joint, over its limit (n,), at the
    worst point and way."""
    pushed_n = PUSH_N + float(gains.values["skin"]["proximity_n"])
    torque = pushed_n * loop.weight[..., None] * np.abs(loop.jacobian)
    return np.asarray((torque / loop.friction).max(axis=(0, 1)) / velocity_limit)
