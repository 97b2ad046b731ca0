# SPDX-License-Identifier: Apache-2.0
"""Masses and friction found by moving: an exciting motion, torques read, and from them the controller's model."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.typing import NDArray
from scipy.signal import savgol_filter

from robotskin.configuring.exploration import PERIOD_S, Exploration, ExplorationError
from robotskin.robots import Robot
from robotskin.robots.free_space import FreeSpace
from robotskin.robots.loading import from_text
from robotskin.selfconfig.dynamics.dynamics import DynamicModel, identify_dynamics
from robotskin.selfconfig.dynamics.excitation import MotionBounds, exciting_trajectory

Array = NDArray[np.float64]

EVERY = 8
"""Control periods between two readings of the torques."""
SMOOTHING = 31
"""Control periods over which velocity is fitted by a parabola, whose slope is the acceleration."""


@dataclass(frozen=True, eq=False)
class TorqueRecording:
    """M readings of n joints: posture rad, velocity rad/s, acceleration rad/s², torque Nm, all (M, n)."""

    posture: Array
    velocity: Array
    acceleration: Array
    torque: Array


def record_torques(
    exploration: Exploration,
    space: FreeSpace,
    random: np.random.Generator,
    speed: float = 1.0,
    acceleration: float = 3.0,
    reach_rad: float = 0.8,
) -> TorqueRecording:
    """Carry out an exciting motion about where the robot stands, and read joints and torques.

    Args:
        exploration: of a robot whose joints all turn.
        space: where it may move.
        random: draws the motion.
        speed: rad/s and acceleration: rad/s² at most.
        acceleration: see speed.
        reach_rad: of every joint about its posture.

    Raises:
        ExplorationError: no motion there is free, or the guard stopped the robot.
    """
    robot, home = exploration.robot, exploration.goal.copy()
    bounds = MotionBounds(
        np.maximum(space.lower, home - reach_rad),
        np.minimum(space.upper, home + reach_rad),
        np.minimum(speed, 0.8 * robot.velocity_limit),
        np.full(robot.joint_count, acceleration),
    )
    try:
        trajectory = exciting_trajectory(robot.model, bounds, random, space.is_free, improvements=20)
    except ValueError as error:
        raise ExplorationError(str(error)) from error
    steps = round(trajectory.period_s / PERIOD_S)
    commanded = trajectory.at(np.linspace(PERIOD_S, trajectory.period_s, steps))[0]
    exploration.move_to(trajectory.at(np.zeros(1))[0][0])
    posture, velocity, torque = (np.empty((steps, robot.joint_count)) for _ in range(3))
    for step in range(steps):
        exploration.follow(commanded[step])
        joints = exploration.joints
        posture[step], velocity[step], torque[step] = joints.position, joints.velocity, joints.effort
    exploration.move_to(home)
    slope = savgol_filter(velocity, SMOOTHING, 2, deriv=1, delta=PERIOD_S, axis=0)
    kept = slice(SMOOTHING, steps - SMOOTHING, EVERY)
    return TorqueRecording(posture[kept], velocity[kept], slope[kept], torque[kept])


def identified(robot: Robot, recording: TorqueRecording) -> tuple[Robot, DynamicModel]:
    """The robot with the masses that its torques tell, for the controller, and the dynamics themselves."""
    found = identify_dynamics(
        robot.model, recording.posture, recording.velocity, recording.acceleration, recording.torque
    )
    text = found.urdf(robot.urdf)
    folder = robot.source.parent if robot.source else Path.cwd()
    return from_text(text, name=robot.name, folder=folder, source=robot.source), found
