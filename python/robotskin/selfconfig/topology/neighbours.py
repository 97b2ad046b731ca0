# SPDX-License-Identifier: Apache-2.0
"""What the running network reports: for each cell, which cell is plugged into each of its four ports."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray

from robotskin import firmware
from robotskin.layout.cell import PORTS


@dataclass(frozen=True, eq=False)
class NeighbourLists:
    """Neighbour lists as reported, defects included; N reports.

    cell: (N,) key of the reporting cell (section unit << 16 | id; a bare id where there is one group).
    neighbour: (N, 4) key of the cell on port p at column p - 1. An id of 0 means nothing is plugged in, an id of 16383
        means the section unit.
    port: (N, 4) the neighbour's own port, 1 to 4, or 0 where the network does not tell it (TUM files do not).

    Raises:
        ValueError: shapes that do not match.
    """

    cell: NDArray[np.int64]
    neighbour: NDArray[np.int64]
    port: NDArray[np.int64]

    def __init__(self, cell: ArrayLike, neighbour: ArrayLike, port: ArrayLike | None = None) -> None:
        cells = np.array(cell, dtype=np.int64)
        neighbours = np.array(neighbour, dtype=np.int64)
        ports = np.zeros_like(neighbours) if port is None else np.array(port, dtype=np.int64)
        for name, array, shape in (
            ("cell", cells, cells.shape[:1]),
            ("neighbour", neighbours, (*cells.shape[:1], PORTS)),
            ("port", ports, (*cells.shape[:1], PORTS)),
        ):
            if array.shape != shape:
                raise ValueError(f"{name}: shape {array.shape}, expected {shape}")
            array.setflags(write=False)
            object.__setattr__(self, name, array)

    def __len__(self) -> int:
        return len(self.cell)

    def faces_cell(self) -> NDArray[np.bool_]:
        """(N, 4) whether the port is said to face a cell: neither nothing nor the section unit."""
        wire_id = self.neighbour & 0xFFFF
        return (wire_id != firmware.ID_NONE) & (wire_id != firmware.ID_SECTION_UNIT)

    @classmethod
    def from_indices(cls, key: ArrayLike, neighbours: ArrayLike) -> NeighbourLists:
        """The lists that a flawless network reports for a known layout.

        Args:
            key: (N,) cell keys.
            neighbours: (N, 4, 2), for own port p at row p - 1 the neighbour's index or -1, and its port 1 to 4; the
                array of the same name of a `Layout`.
        """
        keys, table = np.asarray(key, dtype=np.int64), np.asarray(neighbours, dtype=np.int64)
        connected = table[:, :, 0] >= 0
        return cls(keys, np.where(connected, keys[table[:, :, 0]], 0), np.where(connected, table[:, :, 1], 0))
