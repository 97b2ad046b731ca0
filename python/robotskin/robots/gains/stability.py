# SPDX-License-Identifier: Apache-2.0
"""Whether gains are stable: eigenvalues of the sampled loop of a touched robot, linear about a posture.

The virtual robot, (M + I) a + B v + K q = u, is stepped as the resolver does it (friction at the end of the period,
position with the new velocity). A contact of stiffness k at a point of a link pushes by f = -k nᵀ J q. The skin
measures f late, the filter follows it, and the skin task answers by u = (1 + w) Jᵀ n f  [Cheng19 eq. 14, 16].
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]

DELAY_PERIODS = 5
"""Half a sample of a cell at 250 Hz and up to 3 ms of transport, in control periods of 1 ms."""


@dataclass(frozen=True, eq=False)
class Loop:
    """A robot at a posture, n joints. mass: (n, n) with the added inertia; stiffness, friction: (n).

    jacobian: (P, 3, n) of points on its surface; weight: (P, 3) 1 + w of a push along x, y or z of the base.
    """

    mass: Array
    stiffness: Array
    friction: Array
    jacobian: Array
    weight: Array
    bandwidth_hz: float
    period_s: float

    def free(self) -> Array:
        """(2n, 2n) one period without a contact; states are position and velocity."""
        n, dt = len(self.stiffness), self.period_s
        inverse = np.linalg.inv(self.mass + dt * np.diag(self.friction))
        velocity = np.hstack([-dt * inverse * self.stiffness, np.eye(n) - dt * inverse * self.friction])
        return np.vstack([np.hstack([np.eye(n), np.zeros((n, n))]) + dt * velocity, velocity])

    def touched(self, point: int, axis: int, contact_n_m: float) -> Array:
        """One period in contact; states are position, velocity, the filtered force and the forces on their way."""
        n, dt = len(self.stiffness), self.period_s
        lever = self.jacobian[point, axis]
        size = 2 * n + 1 + DELAY_PERIODS
        step = np.zeros((size, size))
        step[: 2 * n, : 2 * n] = self.free()
        asked = np.linalg.inv(self.mass + dt * np.diag(self.friction)) @ lever * self.weight[point, axis]
        step[n : 2 * n, 2 * n] = dt * asked
        step[:n, 2 * n] = dt * dt * asked
        follow = 1 - np.exp(-2 * np.pi * self.bandwidth_hz * dt)
        step[2 * n, 2 * n], step[2 * n, -1] = 1 - follow, follow
        step[2 * n + 1, :n] = -contact_n_m * lever
        for late in range(1, DELAY_PERIODS):
            step[2 * n + 1 + late, 2 * n + late] = 1.0
        return step

    def settles(self, contact_n_m: float) -> bool:
        """Whether every motion dies away, alone and in contact of this stiffness with each point, each way."""
        return radius(self.free()) < 1.0 and all(
            radius(self.touched(point, axis, contact_n_m)) < 1.0
            for point in range(len(self.jacobian))
            for axis in range(3)
        )


def radius(step: Array) -> float:
    """The largest absolute eigenvalue: below 1 every motion dies away."""
    return float(np.abs(np.linalg.eigvals(step)).max())
