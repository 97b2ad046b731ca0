# SPDX-License-Identifier: Apache-2.0
"""Which cell is plugged into which, as a CSV: a row a plug, `cell,port,neighbour,neighbour_port`, ports from 1."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pandas as pd
from numpy.typing import NDArray

from robotskin.layout.cell import PORTS
from robotskin.selfconfig.readings.recording import RecordingError
from robotskin.selfconfig.topology.neighbours import NeighbourLists
from robotskin.whole_file import whole_file

COLUMNS = ("cell", "port", "neighbour", "neighbour_port")


def save_neighbours(lists: NeighbourLists, path: str | Path) -> None:
    """Write every plug that a cell reports, whole or not at all."""
    facing = lists.faces_cell()
    row, port = np.nonzero(facing)
    columns = (lists.cell[row], port + 1, lists.neighbour[facing], lists.port[facing])
    with whole_file(Path(path)) as partial:
        pd.DataFrame(dict(zip(COLUMNS, columns, strict=True))).to_csv(partial, index=False)


def load_neighbours(path: str | Path, keys: NDArray[np.int64]) -> NeighbourLists:
    """The lists of cells with these keys; a cell without a row is plugged into none.

    Raises:
        RecordingError: no such table, or a row with a cell or a port that does not exist.
    """
    try:
        table = pd.read_csv(path)[list(COLUMNS)].to_numpy(dtype=np.int64)
    except (OSError, ValueError, KeyError) as error:
        raise RecordingError(f"{path}: {error}; the columns are {', '.join(COLUMNS)}, whole numbers") from error
    row = {int(key): number for number, key in enumerate(keys)}
    neighbour, own_port = np.zeros((len(keys), PORTS), dtype=np.int64), np.zeros((len(keys), PORTS), dtype=np.int64)
    for line, (cell, port, other, other_port) in enumerate(table.tolist(), 2):
        strange = [key for key in (cell, other) if key not in row]
        if strange or not (1 <= port <= PORTS and 0 <= other_port <= PORTS):
            what = f"cell {strange[0]} is no sensor" if strange else f"ports {port}, {other_port}: 1 to {PORTS}"
            raise RecordingError(f"{path}, line {line}: {what}")
        neighbour[row[cell], port - 1], own_port[row[cell], port - 1] = other, other_port
    return NeighbourLists(keys, neighbour, own_port)
