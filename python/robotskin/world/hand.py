# SPDX-License-Identifier: Apache-2.0
"""A hand of the world, as users command it."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from robotskin.simulator import HandTask

if TYPE_CHECKING:
    from robotskin.world.world import World


class Hand:
    """A ball that follows the point of a cell it is aimed at, however the robot moves."""

    def __init__(self, world: World, index: int) -> None:
        self._world = world
        self.index = index

    def push(self, cell: int, force_n: float, at_m: tuple[float, float] = (0.0, 0.0)) -> Hand:
        """Come near and push along the cell's inward normal.

        Args:
            cell: index.
            force_n: newton, >= 0, kept until the next task.
            at_m: (x, y) metres in the cell frame; outside the hexagon lies a seam or the patch's edge.
        """
        from robotskin.world.world import WorldError

        if np.shape(at_m) != (2,):
            raise WorldError(f"push at {at_m!r}: (x, y) in metres on the cell; a push lasts until release()")
        if not (np.isfinite(force_n) and force_n >= 0):
            raise WorldError(f"push with {force_n} N: must be finite and not negative")
        with self._world._lock:
            self._world.body.hand_push(self.index, self._world.check_cell(cell), force_n, *at_m)
        return self

    def approach(
        self, cell: int, distance_m: float, speed_m_s: float = 0.2, at_m: tuple[float, float] = (0.0, 0.0)
    ) -> Hand:
        """Hold the ball's surface at a distance in front of a cell's face.

        Args:
            cell: index.
            distance_m: metres; below 0 it presses.
            speed_m_s: metres per second, how fast it gets there.
            at_m: (x, y) metres in the cell frame.
        """
        from robotskin.world.world import WorldError

        if not (np.isfinite(distance_m) and speed_m_s > 0):
            raise WorldError(f"approach to {distance_m} m with {speed_m_s} m/s: must be finite, the speed positive")
        with self._world._lock:
            self._world.body.hand_approach(self.index, self._world.check_cell(cell), distance_m, speed_m_s, *at_m)
        return self

    def leave(self) -> None:
        """Go back along the cell's normal and park."""
        with self._world._lock:
            self._world.body.hand_leave(self.index)

    @property
    def task(self) -> HandTask:
        """What the hand is doing."""
        return self._world.body.hand_task(self.index)

    @property
    def cell(self) -> int:
        """The cell it is or was aimed at."""
        return self._world.body.hand_cell(self.index)

    @property
    def radius_m(self) -> float:
        """Metres."""
        return self._world.scene.hands[self.index].radius_m

    @property
    def position_m(self) -> NDArray[np.float64]:
        """(3,) metres, the ball's centre in the world."""
        with self._world._lock:
            return self._world.scene.data.xpos[self._world.scene.object_body[self.index]].copy()

    @property
    def force_n(self) -> float:
        """Newton, MuJoCo's normal contact force on all cells."""
        return float(self._world.contact_normal_force()[self.index])
