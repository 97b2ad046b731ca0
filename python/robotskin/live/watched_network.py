# SPDX-License-Identifier: Apache-2.0
"""A watched network as a page sees it: looked at from any thread, changed on the network's own."""

from __future__ import annotations

from collections.abc import Callable

from robotskin.live.network_watch import NetworkWatch
from robotskin.viewer.network_view import NetworkReading


class WatchedNetwork:
    """What every `robotskin.viewer.network_view.NetworkView` shares: every method returns at once."""

    def __init__(self, watch: NetworkWatch) -> None:
        self._watch = watch
        self._reading = watch.look()

    def _ask(self, request: Callable[[], None]) -> None:
        """Hand a request to the network's thread."""
        raise NotImplementedError

    def _tell(self, change: str) -> None:
        """Take down what a person changes, where anything is recorded."""

    def look(self) -> None:
        """Take the latest moment; on the network's thread."""
        self._reading = self._watch.look()

    def reading(self) -> NetworkReading:
        """The latest moment."""
        return self._reading

    def toggle_link(self, cell: int, port: int) -> None:
        """Cut the wire at a cell's port, or mend it."""
        self._watch.demand(cell, port)
        self._tell(f"cut or mend the wire at cell {cell} port {port}")
        self._ask(lambda: self._watch.toggle_link(cell, port))

    def disturb_link(self, cell: int, port: int) -> None:
        """Let the wire at a cell's port damage frames for a while."""
        self._watch.demand_wire(cell, port)
        self._tell(f"disturb the wire at cell {cell} port {port}")
        self._ask(lambda: self._watch.disturb_link(cell, port))

    def toggle_cell(self, cell: int) -> None:
        """Kill a cell, or start a dead one."""
        self._watch.demand(cell)
        self._tell(f"kill or start cell {cell}")
        self._ask(lambda: self._watch.toggle_cell(cell))

    def mend(self) -> None:
        """Mend all wires and start all cells."""
        self._tell("mend all")
        self._ask(self._watch.mend)
