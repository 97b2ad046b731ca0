# SPDX-License-Identifier: Apache-2.0
"""How a robot gave way to a touch, beside what the gains say for the force and nearness felt meanwhile."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from robotskin.layout import Layout
from robotskin.model import RobotDynamics
from robotskin.session import SkinnedRobot
from robotskin.session.touches import touch_torque

Floats = NDArray[np.float64]
STEP_S = 0.001
LOOK_S = 0.01
RISE = (0.1, 0.9)


@dataclass(frozen=True)
class TouchAnswer:
    """Both as shares of what the gains say: of the displacement in the end along it, and of its rise from 10 to 90 %.

    Both are 0 where nothing moved or nothing was felt. asked_rad: the largest displacement of a joint that the gains
    say.
    """

    displacement: float
    rise: float
    asked_rad: float


def answer(session: SkinnedRobot, worn: Layout, seconds: float, clock_s: Callable[[], float]) -> TouchAnswer:
    """Let a session run while it is touched, from rest, and compare; `clock_s` tells the robot's time."""
    times, joints, forces, nears = [], [], [], []
    for _ in range(round(seconds / LOOK_S)):
        times.append(clock_s())
        joints.append(np.array(session.joints.position))
        forces.append(np.array(session.skin.normal_force))
        nears.append(np.array(session.skin.proximity))
        session.run(LOOK_S)  # type: ignore[attr-defined]
    moved = np.array(joints) - joints[0]
    time = np.array(times) - times[0]
    torque = [
        touch_torque(session.gains, session.robot.core, worn.skin_model(), force, near, at)
        for force, near, at in zip(forces, nears, joints, strict=True)
    ]
    asked = asked_motion(session, time, np.array(torque), joints[0])
    return compared(time, moved, asked)


def compared(time: Floats, moved: Floats, asked: Floats) -> TouchAnswer:
    """Of displacements (T, n) rad at times (T) s, both from 0: what moved beside what the gains asked for."""
    size = float(np.linalg.norm(asked[-1]))
    if size == 0.0:
        return TouchAnswer(0.0, 0.0, 0.0)
    along = asked[-1] / size
    displacement, largest = float(moved[-1] @ along / size), float(np.abs(asked[-1]).max())
    if displacement == 0.0:
        return TouchAnswer(0.0, 0.0, largest)
    return TouchAnswer(displacement, _rise_s(time, moved @ along) / _rise_s(time, asked @ along), largest)


def asked_motion(session: SkinnedRobot, time: Floats, torque: Floats, home: Floats) -> Floats:
    """(T, n) rad from `home`, of a robot that moves as its virtual one does: (M + I) a + B v + K q = torque (T, n)."""
    values = session.gains.values
    stiffness = np.array(values["joint"]["stiffness"])
    friction = values["virtual_robot"]["friction_s"] * stiffness
    dynamics = RobotDynamics(session.robot.core)
    dynamics.update(home, np.zeros_like(home))
    mass = np.array(dynamics.mass_matrix) + np.diag(values["virtual_robot"]["inertia"])
    implicit = np.linalg.inv(mass + np.diag(friction * STEP_S + stiffness * STEP_S**2))
    position, velocity, at, found = np.zeros_like(home), np.zeros_like(home), time[0], [np.zeros_like(home)]
    for until, pushed in zip(time[1:], (torque[:-1] + torque[1:]) / 2, strict=True):
        while at < until - STEP_S / 2:
            velocity = implicit @ (mass @ velocity + STEP_S * (pushed - stiffness * position))
            position = position + STEP_S * velocity
            at += STEP_S
        found.append(position)
    return np.array(found)


def _rise_s(time: Floats, moved: Floats) -> float:
    """Seconds from a tenth to nine tenths of the end."""
    share = moved / moved[-1]
    crossed = []
    for level in RISE:
        after = int(np.argmax(share >= level))
        low, high = share[after - 1], share[after]
        crossed.append(time[after - 1] + (level - low) / (high - low) * (time[after] - time[after - 1]))
    return float(crossed[1] - crossed[0])
