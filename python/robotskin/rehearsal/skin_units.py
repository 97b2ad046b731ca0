# SPDX-License-Identifier: Apache-2.0
"""A simulated skin on section units that answer on UDP in real time."""

from __future__ import annotations

import time

from robotskin.keys import SkinKeys
from robotskin.layout import Layout
from robotskin.layout.cell_network import CellNetwork
from robotskin.rehearsal.following_world import FollowingWorld
from robotskin.robots import Robot
from robotskin.simulator import UdpTransport


class SkinUnits(FollowingWorld):
    """Serves from construction to `close`; `run` lets real time pass.

    Args:
        robot: that wears the skin.
        layout: N cells.
        keys: of the skin.
        controller: whose joints are followed: address of a UR's, or ros2:DOMAIN.
        host, first_port: where the section units answer, one port after the other; 0 for any.
        seed: of sensors, wires and clocks.

    Raises RehearsalError if no controller answers, RuntimeError if a port is taken.
    """

    def __init__(
        self,
        robot: Robot,
        layout: Layout,
        keys: SkinKeys,
        controller: str,
        host: str = "127.0.0.1",
        first_port: int = 0,
        seed: int = 1,
    ) -> None:
        units = len(CellNetwork.of_layout(layout).unit_descriptions())
        self.transport = UdpTransport(units, host, first_port)
        super().__init__(
            robot,
            layout,
            controller,
            seed,
            key=keys.for_socket(host),
            cell_key=keys.cell_key,
            transport=self.transport,
            epoch_ns=time.time_ns(),
        )

    @property
    def addresses(self) -> list[tuple[str, int]]:
        """(host, port) of each section unit."""
        return list(self.transport.addresses)
