# SPDX-License-Identifier: Apache-2.0
"""What is looked at on a robot before it may move: whether it is at rest, within its limits, and bears its weight."""

from __future__ import annotations

import time

import numpy as np

from robotskin.connecting.errors import ConnectError
from robotskin.model import JointState, PortStatus, RobotDynamics, RobotPort
from robotskin.robots import Robot

REST = 0.02
"""rad/s or m/s."""
GRAVITY_SHARE, GRAVITY_LEAST = 0.25, 4.0
"""How far efforts at rest may be from the model's gravity: a share of the largest, and Nm for friction and tools."""


def check_before_motion(robot: Robot, port: RobotPort, within_s: float = 1.0) -> list[str]:
    """Read the robot at rest and compare it with its model; what was seen, a sentence each.

    Raises ConnectError, naming the joint, for a robot that moves, stands beyond a limit, or bears another weight than
    its model: a joint with a turned sign, another zero, another mounting, or a tool that the model does not have.
    """
    state = JointState(robot.joint_count)
    ends = time.monotonic() + within_s
    while port.read(state) is not PortStatus.ok:
        if time.monotonic() > ends:
            raise ConnectError(f"robot: no state within {within_s} s")
        time.sleep(0.001)
    position, velocity, effort = (np.array(one) for one in (state.position, state.velocity, state.effort))
    for name, at, lower, upper in zip(robot.joint_names, position, robot.lower, robot.upper, strict=True):
        if not lower <= at <= upper:
            raise ConnectError(f"joint {name}: found at {at:.3f}, expected between {lower:.3f} and {upper:.3f}")
    if np.abs(velocity).max() > REST:
        worst = int(np.abs(velocity).argmax())
        raise ConnectError(f"joint {robot.joint_names[worst]}: found moving at {velocity[worst]:.3f} rad/s")
    seen = ["every joint is within its limits, and at rest"]
    if not effort.any():
        return [*seen, "the port tells no effort: weight and signs of the joints were not checked"]
    dynamics = RobotDynamics(robot.core)
    dynamics.update(position, np.zeros_like(position))
    weight = dynamics.gravity_torque
    allowed = GRAVITY_LEAST + GRAVITY_SHARE * float(np.abs(weight).max())
    apart = np.abs(effort - weight)
    worst = int(apart.argmax())
    if apart[worst] > allowed:
        raise ConnectError(
            f"joint {robot.joint_names[worst]}: found an effort of {effort[worst]:.1f} Nm at rest, expected "
            f"{weight[worst]:.1f} ± {allowed:.1f} Nm of the model's weight: check signs and zeros of the joints, how "
            "the robot is mounted, and its tool"
        )
    return [*seen, f"efforts agree with the model's weight within {apart[worst]:.1f} Nm"]
