# SPDX-License-Identifier: Apache-2.0
"""The trees that the cells of a skin have grown, as they report them."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np
from numpy.typing import NDArray

from robotskin.layout.layout import Layout


def grown_tree(layout: Layout, topology: Mapping[str, NDArray[Any]]) -> NDArray[np.int64]:
    """(N,) the parent of each cell as the cells report it, -1 for a section unit or a cell that has not reported.

    `topology` is the driver's, with a row for every cell of the layout in its order.
    """
    cells = np.arange(len(layout))
    port = np.asarray(topology["parent_port"])[cells].astype(int)
    told = (np.asarray(topology["heard_ns"])[cells] > 0) & (port >= 1) & (port <= layout.neighbours.shape[1])
    return np.where(told, layout.neighbours[cells, np.where(told, port - 1, 0), 0], -1)
