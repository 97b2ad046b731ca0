# SPDX-License-Identifier: Apache-2.0
"""A simulated skin of which one cell runs on the emulated chip, with a driver that tells it how the joints stand."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
from numpy.typing import NDArray

from robotskin import firmware
from robotskin.driver import Driver
from robotskin.simulator import ExternalCell, InProcess, LineQuality, NetworkOptions, UnitDescription, World
from robotskin.world.ideal import default_processor
from robotskin_lab.chip.emulated_cell import Answer, EmulatedCell
from robotskin_lab.chip.image import ChipImage

MS = 1_000_000
KEY = bytes(range(firmware.CELL_KEY_BYTES))


def sheet(columns: int, rows: int) -> NDArray[np.int32]:
    """(N, 4, 2) neighbours of a rectangular sheet: cell and its port by own port - 1, -1 where none is."""
    neighbours = np.full((columns * rows, firmware.PORTS, 2), -1, dtype=np.int32)
    for row in range(rows):
        for column in range(columns):
            for port, (to_column, to_row) in enumerate(
                ((column + 1, row), (column, row + 1), (column - 1, row), (column, row - 1))
            ):
                if 0 <= to_column < columns and 0 <= to_row < rows:
                    neighbours[row * columns + column, port] = (to_row * columns + to_column, (port + 2) % 4 + 1)
    return neighbours


class ChipRig:
    """A sheet of cells on section units, host-built but for one, authenticated, told how to compute torques.

    Args:
        image: what the chip runs.
        columns, rows: of the sheet.
        roots: (cell, port) at each port of the one section unit.
        chip_cell: the cell that is emulated.
        told: the torque parameters of every cell.
        codes: where the joints of its limb are, as they are broadcast.
        line: quality of the wires.
    """

    def __init__(
        self,
        image: ChipImage,
        columns: int,
        rows: int,
        roots: list[tuple[int, int]],
        chip_cell: int,
        told: firmware.TorqueParameters,
        codes: list[int],
        seed: int = 1,
        line: LineQuality | None = None,
    ) -> None:
        neighbours = sheet(columns, rows)
        cells = len(neighbours)
        options = NetworkOptions()
        options.seed = seed
        options.processor = default_processor()
        options.unasked = True
        options.line = line or LineQuality()
        options.set_cell_key(KEY)
        self.mailbox = InProcess()
        units = [UnitDescription(0, 0, roots)]
        self.world = World(None, neighbours, [0] * cells, units, options, self.mailbox, 0.001)
        self.network = self.world.network
        self.limb, self.codes = LIMB, codes
        for cell in range(cells):
            self.network.set_torque_image(cell, told.image)
        self.driver = Driver([], spare_cells=cells, spare_groups=1, session_seed=seed)
        self.chip = EmulatedCell(image)
        self.answered: Callable[[Answer], object] = lambda answer: None
        """Is given what the chip has answered to each input."""
        self.external = ExternalCell(self._step)
        self.network.put(chip_cell, self.external)

    def _step(self, kind: int, port: int, sent: int, fault: bool, content: object, now_us: int) -> Answer:
        answer = self.chip(kind, port, sent, fault, content, now_us)
        self.answered(answer)
        return answer

    def run_ms(self, milliseconds: int, each: Callable[[], object] = lambda: None) -> None:
        """Let virtual time pass, in which the driver does its part every millisecond."""
        for _ in range(milliseconds):
            each()
            self.world.run(MS)
            now_ns = self.world.time_ns
            for _, when_ns, datagram in self.mailbox.take():
                self.driver.handle(datagram, when_ns)
            self.driver.publish(now_ns)
            self.driver.set_joints(self.limb, self.codes, now_ns=now_ns)
            for _, _, datagram in self.driver.downlink(now_ns):
                self.mailbox.post(0, datagram)

    def press(self, counts: int) -> None:
        """Let every cell read so many counts on its first force sensor, by its own offset."""
        self.driver.command("offset", counts, 1)


LIMB = 2


def told_cell(chain: firmware.Chain) -> firmware.TorqueParameters:
    """Parameters of a cell on a chain, which asks for an eighth of a newton a count of force, however small."""
    return firmware.TorqueParameters(chain, firmware.TouchGains((0, 1, 1 << 12, 15), (0, 1, 1 << 12, 15)), LIMB)
