# SPDX-License-Identifier: Apache-2.0
"""Which cell is plugged into which, as a CSV: a row a plug, `cell,port,neighbour,neighbour_port`, ports from 1.

The neighbour's port is left empty where the network does not tell it.
"""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pandas as pd
from numpy.typing import NDArray

from robotskin.layout.cell import PORTS
from robotskin.selfconfig.readings.number_table import NumberTable
from robotskin.selfconfig.readings.recording import RecordingError
from robotskin.selfconfig.topology.neighbours import NeighbourLists
from robotskin.whole_file import whole_file

COLUMNS = ("cell", "port", "neighbour", "neighbour_port")
WHOLE = "must be a whole number, the name of a sensor"


def save_neighbours(lists: NeighbourLists, path: str | Path) -> None:
    """Write every plug that a cell reports, whole or not at all."""
    facing = lists.faces_cell()
    row, port = np.nonzero(facing)
    told = [str(number) if number else "" for number in lists.port[facing].tolist()]
    columns = (lists.cell[row], port + 1, lists.neighbour[facing], told)
    with whole_file(Path(path)) as partial:
        pd.DataFrame(dict(zip(COLUMNS, columns, strict=True))).to_csv(partial, index=False)


def load_neighbours(path: str | Path, keys: NDArray[np.int64]) -> NeighbourLists:
    """The lists of cells with these keys; a cell without a row is plugged into none.

    Raises:
        RecordingError: no such table, a cell or a port that does not exist, or two plugs on one port.
    """
    table = NumberTable.load(path)
    lacking = [name for name in COLUMNS if name not in table.names]
    if lacking:
        raise RecordingError(f"{path}: no column {', '.join(lacking)}; the columns are {', '.join(COLUMNS)}")
    plugs = table.numbers(COLUMNS)
    ports = f"must be a port, 1 to {PORTS}"
    for column, (name, must) in enumerate(zip(COLUMNS, (WHOLE, ports, WHOLE, ports), strict=True)):
        fits = plugs[:, column] == np.rint(plugs[:, column])
        if must == ports:
            fits &= (plugs[:, column] >= 1) & (plugs[:, column] <= PORTS)
            # Networks that tell only the neighbour leave its port empty.
            fits |= np.isnan(plugs[:, column]) & (name == "neighbour_port")
        table.require(name, fits, must)
    row = {int(key): number for number, key in enumerate(keys)}
    neighbour, own_port = np.zeros((len(keys), PORTS), dtype=np.int64), np.zeros((len(keys), PORTS), dtype=np.int64)
    line: dict[tuple[int, int], int] = {}
    for number, (cell, port, other, other_port) in enumerate(np.nan_to_num(plugs).astype(np.int64).tolist()):
        for key in (cell, other):
            if key not in row:
                known = ", ".join(map(str, keys[:5].tolist()))
                table.refuse(number, f"cell {key} is no sensor; they are {known}{' ...' * (len(keys) > 5)}")
        if (cell, port) in line:
            table.refuse(number, f"port {port} of cell {cell} has a plug already, in line {line[cell, port]}")
        line[cell, port] = int(table.line[number])
        neighbour[row[cell], port - 1], own_port[row[cell], port - 1] = other, other_port
    return NeighbourLists(keys, neighbour, own_port)
