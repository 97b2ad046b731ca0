# SPDX-License-Identifier: Apache-2.0
"""Hundreds of cells on the simulated links of the core, without a body: what reached the host, record by record."""

from dataclasses import dataclass, field

import numpy as np

from robotskin.simulator import InProcess, LineQuality, NetworkOptions, UnitDescription, World
from robotskin_lab import firmware

MS = 1_000_000


def sheet(columns: int, rows: int, patches: int = 1) -> np.ndarray:
    """Neighbours (N, 4, 2) of rectangular patches of cells: cell and its port by own port - 1, -1 where none is."""
    size = columns * rows
    neighbours = np.full((patches * size, 4, 2), -1, dtype=np.int32)
    for patch in range(patches):
        for row in range(rows):
            for column in range(columns):
                cell = patch * size + row * columns + column
                for port, (d_column, d_row) in enumerate(((1, 0), (0, 1), (-1, 0), (0, -1))):
                    if 0 <= column + d_column < columns and 0 <= row + d_row < rows:
                        neighbours[cell, port] = (cell + d_row * columns + d_column, (port + 2) % 4 + 1)
    return neighbours


@dataclass
class Heard:
    """One record at the host. `late_ms`: from the epoch's tick to the datagram, of torque sums."""

    time_ns: int  # when its datagram left the section unit
    arrival_ns: int  # when it reached the section unit
    unit: int
    port: int
    name: str
    fields: dict[str, int] = field(repr=False)


class LargeWorld:
    """A network without a body. `roots` are the (cell, port) at the ports of one section unit."""

    def __init__(self, neighbours: np.ndarray, roots: list[tuple[int, int]], seed: int, **options: object) -> None:
        self.cells = len(neighbours)
        self.neighbours = neighbours
        self.mailbox = InProcess()
        self.options = NetworkOptions()
        self.options.seed = seed
        self.options.unasked = True
        self.options.batch_us = 1000
        line = LineQuality()
        for name, value in options.items():
            setattr(line if hasattr(line, name) else self.options, name, value)
        self.options.line = line
        units = [UnitDescription(0, 0, roots)]
        self.world = World(None, neighbours, [0] * self.cells, units, self.options, self.mailbox, 0.001)
        self.network = self.world.network

    def run_ms(self, milliseconds: float) -> None:
        self.world.run(round(milliseconds * MS))

    def take(self, *names: str) -> list[Heard]:
        """Records since the last call, those of the named frames (all if none is named)."""
        numbers = {number for name, number, _ in firmware.FRAME_TYPES if not names or name in names}
        result = []
        for unit, time_ns, data in self.mailbox.take():
            for at in range(firmware.DATAGRAM_HEADER_BYTES, len(data), firmware.DATAGRAM_RECORD_BYTES):
                if data[at] >> 4 not in numbers:
                    continue
                content = data[at : at + firmware.CONTENT_BYTES]
                name, fields = firmware.unpack(content + firmware.crc16(content).to_bytes(2, "big"))
                port, age_us = data[at + 18] >> 4, int.from_bytes(data[at + 18 : at + 20], "big") & 0xFFF
                result.append(Heard(time_ns, time_ns - 1000 * age_us, unit, port, name, fields))
        return result

    def parent(self, cell: int) -> tuple[int, int] | None:
        """Cell and port of the link to a cell's parent, if it has one."""
        port = self.network.cell_parent_port(cell)
        return (cell, port) if port else None
