# SPDX-License-Identifier: Apache-2.0
"""A simulated skin on pseudo-terminals: host-built cells in real time, whose sensors read the simulated world.

`robotskin unit` serves such lines as it serves those of hardware.
"""

from __future__ import annotations

import os
import secrets
from pathlib import Path
from typing import Any

import numpy as np

from robotskin.keys import SkinKeys
from robotskin.layout import Layout
from robotskin.layout.cell_network import CellNetwork
from robotskin.rehearsal.following_world import FollowingWorld
from robotskin.robots import Robot
from robotskin.serial_lines import CellRunner, HostCell, SetSensors

READ_STEPS = 2
"""Steps of the world between two readings of its sensors; cells sample every four."""
NOTHING = (-1, 0, -1)


def host_cells(layout: Layout, fresh: bool = True) -> tuple[list[HostCell], list[tuple[int, int, int]]]:
    """The cells of a layout, wired as it says, and (group, unit, port) of each line, in the order of the lines.

    fresh: their clocks and random numbers are other ones at each start; else those of their index.
    """
    network = CellNetwork.of_layout(layout)
    ends = [[NOTHING] * 4 for _ in range(len(layout))]
    for one, port, other, other_port in network.links.tolist():
        ends[one][port - 1] = (other, other_port, -1)
        ends[other][other_port - 1] = (one, port, -1)
    for line, cable in enumerate(network.cables):
        ends[cable.cell][cable.cell_port - 1] = (-1, 0, line)
    random = secrets.randbits(30) if fresh else 0
    cells = [HostCell(at + 1, ends[at], int(layout.id[at]), random + at + 1) for at in range(len(layout))]
    return cells, [(cable.group, cable.unit, cable.port) for cable in network.cables]


class SerialSkin(FollowingWorld):
    """Cells of a layout on pseudo-terminals from construction to `close`; `run` lets real time pass.

    Args:
        robot: that wears the skin; layout: N cells; keys: of the skin.
        folder: where the pseudo-terminals get names, `group1_unit0_port1` and so on.
        controller: address of a UR controller whose joints are followed; None: the robot stands at its home.
        seed: of the sensors.

    Raises SerialError where no pseudo-terminal can be made, RehearsalError if no controller answers.
    """

    def __init__(
        self,
        robot: Robot,
        layout: Layout,
        keys: SkinKeys,
        folder: str | Path,
        controller: str | None = None,
        seed: int = 1,
    ) -> None:
        super().__init__(robot, layout, controller, seed, powered=False)
        cells, places = host_cells(layout)
        Path(folder).mkdir(parents=True, exist_ok=True)
        self.lines = {place: os.path.join(folder, "group{}_unit{}_port{}".format(*place)) for place in places}
        """Path of the pseudo-terminal of each cable, by (group, unit, port)."""
        self.sensors = SetSensors(len(layout))
        self._steps = 0
        self.after_step()
        self.runner = CellRunner(cells, keys.cell_key, self.sensors, [(path, True) for path in self.lines.values()])
        self.runner.start()

    def after_step(self) -> None:
        """The cells' sensors read the world."""
        if self._steps % READ_STEPS == 0:
            self.sensors.set(np.ascontiguousarray(self.world.body.sample_all(self.world.now_ns)))
        self._steps += 1

    def report(self) -> dict[str, Any]:
        """Counts of lines, cells and stalls so far."""
        return dict(self.runner.report())

    def pull(self, line: int, pulled: bool) -> None:
        """Pull a cable, or put it back."""
        self.runner.pull(line, pulled)

    def close(self) -> None:
        """End."""
        self.runner.stop()
        super().close()
