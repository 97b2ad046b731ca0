# SPDX-License-Identifier: Apache-2.0
"""A session whose robot stands by skin and inertial unit alone: no sensor at its ankles."""

from __future__ import annotations

from robotskin.apps.balance.sole_port import SolePort
from robotskin.layout import Layout
from robotskin.robots import Robot
from robotskin.robots.gains import GainSet
from robotskin.session import Session


class SoleSession(Session):
    """A session whose forces at the feet are what cells in the soles tell; `cells`: of each sole, 7 or 32.

    The cells of the soles stand beside those of the layout. They are sampled as those are, but have no network.
    """

    def __init__(
        self,
        robot: Robot,
        layout: Layout,
        cells: int,
        *,
        seed: int = 1,
        gains: GainSet | None = None,
        self_collision: bool = False,
        threads: int = 1,
    ) -> None:
        super().__init__(
            robot,
            layout,
            seed=seed,
            gains=gains,
            self_collision=self_collision,
            threads=threads,
            port=lambda inner: SolePort(self.world, robot, inner, cells, seed),
        )
