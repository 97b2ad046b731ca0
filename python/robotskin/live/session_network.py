# SPDX-License-Identifier: Apache-2.0
"""The cells' network of a running session, to look at and to meddle with while the robot moves.

The network has every cell that the robot wears; the page knows the cells of the believed layout, in its order.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from robotskin.layout import Layout
from robotskin.live.network_watch import NetworkError, NetworkWatch
from robotskin.live.watched_network import WatchedNetwork
from robotskin.viewer.network_view import NO_PATH, NetworkReading


class SessionNetwork(WatchedNetwork):
    """The `robotskin.viewer.network_view.NetworkView` of a session; `ask` hands a request to the session's thread.

    Paths run through all cells, and only those of `estimated_layout` are told. A path
    that ends at a cable whose plug `estimated_layout` does not know is told as none.

    Args:
        watch: of all cells that the robot wears.
        ask: see above.
        estimated_layout: the layout that the page shows, N cells.
        cells: (N,) index in the watched layout of each of its cells.
    """

    paced = False

    def __init__(
        self,
        watch: NetworkWatch,
        ask: Callable[[Callable[[], object]], None],
        estimated_layout: Layout,
        cells: NDArray[np.int64],
    ) -> None:
        super().__init__(watch)
        self._hand_over = ask
        self._cells = cells
        known = {
            (int(cells[place.cell]), place.cell_port): index
            for index, place in enumerate(estimated_layout.section_unit_ports)
        }
        plugs = [(place.cell, place.cell_port) for place in watch.layout.section_unit_ports]
        # The last entry is that of NO_PATH, which is -1.
        self._cable = np.array([*(known.get(plug, NO_PATH) for plug in plugs), NO_PATH])

    def reading(self) -> NetworkReading:
        """The latest moment."""
        whole, cells = super().reading(), self._cells
        return replace(
            whole,
            parent_port=whole.parent_port[cells],
            cable=self._cable[whole.cable[cells]],
            hops=whole.hops[cells],
            alive=whole.alive[cells],
            cut=whole.cut[cells],
            damaged=whole.damaged[cells],
            moved_s=whole.moved_s[cells],
            damaged_s=whole.damaged_s[cells],
        )

    def toggle_link(self, cell: int, port: int) -> None:
        """Cut the wire at a cell's port, or mend it."""
        super().toggle_link(self._worn(cell), port)

    def disturb_link(self, cell: int, port: int) -> None:
        """Let the wire at a cell's port damage frames for a while."""
        super().disturb_link(self._worn(cell), port)

    def toggle_cell(self, cell: int) -> None:
        """Kill a cell, or start a dead one."""
        super().toggle_cell(self._worn(cell))

    def _worn(self, cell: int) -> int:
        if not 0 <= cell < len(self._cells):
            raise NetworkError(f"cell {cell}: there are cells 0 to {len(self._cells) - 1}")
        return int(self._cells[cell])

    def _ask(self, request: Callable[[], None]) -> None:
        self._hand_over(request)

    def set_pace(self, pace: float) -> None:
        """Refused: the network's time is the session's."""
        raise NetworkError(f"pace {pace}: a session's network runs in the session's time")
