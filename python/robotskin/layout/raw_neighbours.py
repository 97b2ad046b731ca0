# SPDX-License-Identifier: Apache-2.0
"""Which port is plugged into which in a skin that a file describes by the neighbours' ids."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from robotskin import firmware
from robotskin.layout.cell import PORTS
from robotskin.layout.raw_layout import RawCell


def neighbours_of(cells: Sequence[RawCell]) -> tuple[NDArray[np.int32], dict[int, int]]:
    """Neighbours that both cells list, and the ports that face an interface box.

    Returns:
        (N, 4, 2) as in `Layout`, and by cell index the port 1 to 4 whose neighbour has the section unit's id.
    """
    count = len(cells)
    index_of = {(cell.group, cell.id): index for index, cell in enumerate(cells)}
    neighbours = np.full((count, PORTS, 2), (-1, 0), dtype=np.int32)
    box_ports: dict[int, int] = {}
    for index, cell in enumerate(cells):
        for port, other in enumerate(cell.neighbours):
            partner = index_of.get((cell.group, other))
            if other == firmware.ID_SECTION_UNIT:
                box_ports[index] = port + 1
            elif partner is not None and partner != index and cell.id in cells[partner].neighbours:
                neighbours[index, port] = partner, cells[partner].neighbours.index(cell.id) + 1
    # An edge counts if each end names the other's port; the ends of a real plug do.
    for index, port in np.argwhere(neighbours[:, :, 0] >= 0):
        other, other_port = neighbours[index, port]
        if tuple(neighbours[other, other_port - 1]) != (index, port + 1):
            neighbours[index, port] = -1, 0
    return neighbours, box_ports
