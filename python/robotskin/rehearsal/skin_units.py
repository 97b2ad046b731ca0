# SPDX-License-Identifier: Apache-2.0
"""A simulated skin on section units that answer on UDP in real time; its arm goes where a controller's joints go.

Touches act on the skin alone: the arm that wears it follows the controller stiffly, so that the robot moves only by
what its controller is told.
"""

from __future__ import annotations

import time

from robotskin.keys import SkinKeys
from robotskin.layout import Layout
from robotskin.layout.cell_network import CellNetwork
from robotskin.model import CommandMode, JointCommand
from robotskin.rehearsal.joint_watch import JointWatch
from robotskin.robots import Robot
from robotskin.simulator import UdpTransport
from robotskin.world import World

STEP_S = 0.001
BEHIND_S = 0.5
"""How far the world may fall behind the clock on the wall before it gives up catching up: then the cells are stale."""


class SkinUnits:
    """Serves from construction to `close`; `run` lets real time pass.

    Args:
        robot: that wears the skin.
        layout: N cells.
        keys: of the skin.
        controller: address of the UR controller whose joints are followed.
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
        self._joints = JointWatch(controller)
        time.sleep(0.05)
        posture = self._joints.look()
        units = len(CellNetwork.of_layout(layout).unit_descriptions())
        self.transport = UdpTransport(units, host, first_port)
        self.world = World(
            layout,
            robot,
            seed,
            posture=posture,
            key=keys.for_socket(host),
            cell_key=keys.cell_key,
            transport=self.transport,
            epoch_ns=time.time_ns(),
        )
        self._command = JointCommand(CommandMode.position, robot.joint_count)
        self._due = time.monotonic()
        self.late_s = 0.0
        """By which the world has fallen behind for good: this machine is too slow for so many cells."""

    @property
    def addresses(self) -> list[tuple[str, int]]:
        """(host, port) of each section unit."""
        return list(self.transport.addresses)

    def run(self, seconds: float) -> None:
        """Let real time pass."""
        ends = time.monotonic() + seconds
        while (now := time.monotonic()) < ends:
            self._command.value = self._joints.look()
            self.world.port.write(self._command)
            self.world.step(STEP_S)
            self._due += STEP_S
            if self._due < now - BEHIND_S:
                self._due, self.late_s = now, self.late_s + now - self._due
            ahead = self._due - time.monotonic()
            if ahead > 0:
                time.sleep(ahead)

    def push(self, cell: int, force_n: float) -> None:
        """A hand pushes a cell until `release`."""
        self.world.push(cell, force_n)

    def release(self) -> None:
        """Every hand leaves."""
        self.world.release()

    def force_n(self) -> float:
        """Newton: what the cells truly feel, in sum."""
        return float(self.world.cell_true_force().sum())

    def close(self) -> None:
        """End."""
        self._joints.close()
