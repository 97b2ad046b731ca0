# SPDX-License-Identifier: Apache-2.0
"""Motions that make torques tell most about masses: finite Fourier series within the robot's bounds, optimised.

In: a kinematic model and its bounds. Out: a `FourierTrajectory`. Once a configuration.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np
import pinocchio
from numpy.typing import NDArray

from robotskin.selfconfig.dynamics.torque_regressor import base_columns, torque_regressor

Array = NDArray[np.float64]


@dataclass(frozen=True, eq=False)
class FourierTrajectory:
    """A periodic motion of n joints (Swevers et al., IEEE T-RA 13(5), 1997, eq. 9), at rest at its beginning and end.

        q̇(t) = Σₖ sine_k cos(k ω t) + cosine_k sin(k ω t)        k = 1 … H, ω = 2π / period

    Σₖ sine_k = 0 and Σₖ k cosine_k = 0 make velocity and acceleration zero at t = 0.
    centre: (n) rad, the mean posture; sine, cosine: (n, H) rad/s; period_s.
    """

    centre: Array
    sine: Array
    cosine: Array
    period_s: float

    def at(self, time_s: Array) -> tuple[Array, Array, Array]:
        """Posture rad, velocity rad/s and acceleration rad/s², each (M, n), at times (M,)."""
        rate = 2 * np.pi / self.period_s * np.arange(1, self.sine.shape[1] + 1)
        angle = np.asarray(time_s)[:, None] * rate
        wave, quarter = np.sin(angle), np.cos(angle)
        posture = self.centre + wave @ (self.sine / rate).T - quarter @ (self.cosine / rate).T
        velocity = quarter @ self.sine.T + wave @ self.cosine.T
        acceleration = quarter @ (self.cosine * rate).T - wave @ (self.sine * rate).T
        return posture, velocity, acceleration


@dataclass(frozen=True, eq=False)
class MotionBounds:
    """Of n joints: lower and upper (n) rad, velocity (n) rad/s, acceleration (n) rad/s²."""

    lower: Array
    upper: Array
    velocity: Array
    acceleration: Array


def random_trajectory(
    bounds: MotionBounds, random: np.random.Generator, harmonics: int = 5, period_s: float = 10.0, tries: int = 1
) -> FourierTrajectory:
    """A series with random coefficients, as large as the bounds allow about a random mean posture."""
    count = len(bounds.lower)
    sine, cosine = random.standard_normal((2, count, harmonics))
    centre = random.uniform(bounds.lower, bounds.upper)
    return _within(FourierTrajectory(centre, sine, cosine, period_s), bounds)


def exciting_trajectory(
    model: pinocchio.Model,
    bounds: MotionBounds,
    random: np.random.Generator,
    is_free: Callable[[Array], bool] | None = None,
    harmonics: int = 5,
    period_s: float = 10.0,
    candidates: int = 30,
    improvements: int = 60,
) -> FourierTrajectory:
    """A trajectory whose torques tell the base parameters apart as well as can be found.

    The condition number of the regressor of the base parameters, its columns scaled to one, is lowered: by the best of
    random series, then by changes to it that are kept where they help.

    Args:
        model: kinematics of n revolute joints; masses are not used.
        bounds: of the motion.
        random: draws the series.
        is_free: whether a posture (n) touches nothing; every posture of the result is.
        harmonics: of the series.
        period_s: of the series.
        candidates: random series to begin with.
        improvements: changes tried.

    Raises:
        ValueError: none of the candidates is free.
    """
    coarse = np.linspace(0.0, period_s, 60, endpoint=False)
    fine = np.linspace(0.0, period_s, 200, endpoint=False)

    def free(trajectory: FourierTrajectory) -> bool:
        return is_free is None or all(is_free(posture) for posture in trajectory.at(fine)[0])

    def badness(trajectory: FourierTrajectory) -> float:
        regressor = torque_regressor(model, *trajectory.at(coarse))
        columns = regressor[:, base_columns(regressor)]
        return float(np.linalg.cond(columns / np.linalg.norm(columns, axis=0)))

    drawn = [random_trajectory(bounds, random, harmonics, period_s) for _ in range(candidates)]
    found = [trajectory for trajectory in drawn if free(trajectory)]
    if not found:
        raise ValueError(f"none of {candidates} trajectories is free of contact: give narrower bounds")
    best = min(found, key=badness)
    least = badness(best)
    for number in range(improvements):
        size = 0.5 * 0.97**number
        changed = replace(
            best,
            sine=best.sine + size * best.sine.std() * random.standard_normal(best.sine.shape),
            cosine=best.cosine + size * best.cosine.std() * random.standard_normal(best.cosine.shape),
            centre=best.centre + 0.2 * size * (bounds.upper - bounds.lower) * random.uniform(-1, 1, len(best.centre)),
        )
        tried = _within(changed, bounds)
        value = badness(tried)
        if value < least and free(tried):
            best, least = tried, value
    return best


def _within(trajectory: FourierTrajectory, bounds: MotionBounds) -> FourierTrajectory:
    """At rest at the beginning, as large as allowed, and moved into the joints' range."""
    order = np.arange(1, trajectory.sine.shape[1] + 1)
    sine = trajectory.sine - trajectory.sine.mean(axis=1, keepdims=True)
    cosine = trajectory.cosine - np.outer(trajectory.cosine @ order, order) / (order @ order)
    still = replace(trajectory, sine=sine, cosine=cosine, centre=np.zeros_like(trajectory.centre))
    posture, velocity, acceleration = still.at(np.linspace(0.0, trajectory.period_s, 500))
    scale = np.minimum(
        bounds.velocity / np.abs(velocity).max(axis=0), bounds.acceleration / np.abs(acceleration).max(axis=0)
    )
    scale = np.minimum(scale, (bounds.upper - bounds.lower) / np.ptp(posture, axis=0)) * 0.98
    # The extremes lie between the instants looked at, a little farther out.
    low, high = 1.01 * posture.min(axis=0) * scale, 1.01 * posture.max(axis=0) * scale
    centre = np.clip(trajectory.centre, bounds.lower - low, bounds.upper - high)
    return FourierTrajectory(centre, sine * scale[:, None], cosine * scale[:, None], trajectory.period_s)
