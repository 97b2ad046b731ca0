# SPDX-License-Identifier: Apache-2.0
"""Motor babbling, part 2: one joint swings and comes back to where it started, never too fast, hard or sudden."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from robotskin.robots.free_space import FreeSpace
from robotskin.selfconfig.babbling.postures import BabblingError

Array = NDArray[np.float64]


@dataclass(frozen=True)
class MotionLimits:
    """Bounds of a babbling joint: velocity rad/s, acceleration rad/s², jerk rad/s³ (or m)."""

    velocity: float = 1.0
    acceleration: float = 8.0
    jerk: float = 150.0


@dataclass(frozen=True, eq=False)
class JointSine:
    """q(t) = centre + A sin²(π t / T) sin(2π f t) on one joint, for 0 <= t <= T.

    The bell lets position, velocity and acceleration start and end at zero, so that the jerk stays bounded too.
    joint: index; centre: (n) posture; amplitude: A in rad or m; frequency_hz: f; duration_s: T.
    """

    joint: int
    centre: Array
    amplitude: float
    frequency_hz: float
    duration_s: float

    def displacement(self, time_s: Array, derivative: int = 0) -> Array:
        """Displacement of the joint at times (M,) s, or its first, second, third... derivative."""
        fast, slow = 2 * np.pi * self.frequency_hz, 2 * np.pi / self.duration_s
        time_s = np.asarray(time_s, dtype=float)
        # sin²(Ωt/2) sin(ωt) is three sines, whose derivatives are sines a quarter turn on.
        total = np.zeros_like(time_s)
        for share, rate in ((0.5, fast), (-0.25, fast + slow), (-0.25, fast - slow)):
            total += share * rate**derivative * np.sin(rate * time_s + derivative * np.pi / 2)
        return self.amplitude * total

    def posture(self, time_s: Array) -> Array:
        """(M, n) postures at times (M,)."""
        result = np.tile(self.centre, (len(time_s), 1))
        result[:, self.joint] += self.displacement(time_s)
        return result


@dataclass(frozen=True, eq=False)
class VelocitySine(JointSine):
    """The paper's exploration pattern (IV-A1): one period of a velocity sine, q(t) = centre + A (1 - cos(2π f t)) / 2.

    It returns to where it began, but its acceleration starts and ends at its largest value at once, and its two
    extrema of that sign are equally high.
    """

    def displacement(self, time_s: Array, derivative: int = 0) -> Array:
        """Displacement of the joint at times (M,) s, or its first, second, third... derivative."""
        rate = 2 * np.pi * self.frequency_hz
        time_s = np.asarray(time_s, dtype=float)
        constant = 1.0 if derivative == 0 else 0.0
        wave = rate**derivative * np.cos(rate * time_s + derivative * np.pi / 2)
        return 0.5 * self.amplitude * (constant - wave)


def plan_joint_sine(
    space: FreeSpace,
    joint: int,
    centre: Array,
    limits: MotionLimits = MotionLimits(),
    frequency_hz: float = 1.0,
    cycles: int = 4,
    least_amplitude: float = 0.01,
) -> JointSine:
    """The widest swing of a joint within its bounds that touches nothing.

    Args:
        space: where the robot may move.
        joint: index of the joint.
        centre: (n) posture at which it starts and ends.
        limits: of the motion; the robot's own velocity limit holds too.
        frequency_hz: of the sine.
        cycles: of the sine in the whole motion.
        least_amplitude: rad or m, below which a swing is of no use.

    Raises:
        BabblingError: no swing of that size is free; says what is in the way.
    """
    centre = np.asarray(centre, dtype=float)
    name = space.robot.joint_names[joint]
    duration_s = cycles / frequency_hz
    unit = JointSine(joint, centre, 1.0, frequency_hz, duration_s)
    time_s = np.linspace(0.0, duration_s, 200 * cycles + 1)
    bounds = (
        (1, min(limits.velocity, float(space.robot.velocity_limit[joint]))),
        (2, limits.acceleration),
        (3, limits.jerk),
    )
    amplitude = min(bound / np.abs(unit.displacement(time_s, derivative)).max() for derivative, bound in bounds)
    trouble: str | None = "its bounds allow less"
    while amplitude >= least_amplitude:
        swing = JointSine(joint, centre, amplitude, frequency_hz, duration_s)
        trouble = _obstacle(space, swing, time_s)
        if trouble is None:
            return swing
        amplitude *= 0.8
    raise BabblingError(f"joint {name} cannot swing by {least_amplitude}: {trouble}")


def _obstacle(space: FreeSpace, swing: JointSine, time_s: Array, steps: int = 13) -> str | None:
    """What is in the way between the two ends of the swing."""
    reach = swing.displacement(time_s)
    for displacement in np.linspace(reach.min(), reach.max(), steps):
        posture = swing.centre.copy()
        posture[swing.joint] += displacement
        trouble = space.why_not(posture)
        if trouble:
            return trouble
    return None
