"""The cells' network of a running session, to look at and to meddle with while the robot moves."""

from __future__ import annotations

from collections.abc import Callable

from robotskin.apps.network_watch import NetworkError, NetworkWatch
from robotskin.viewer.network_view import NetworkReading


class SessionNetwork:
    """The `robotskin.viewer.network_view.NetworkView` of a session; `ask` hands a request to the session's thread."""

    paced = False

    def __init__(self, watch: NetworkWatch, ask: Callable[[Callable[[], object]], None]) -> None:
        self._watch = watch
        self._ask = ask
        self._reading = watch.look()

    def look(self) -> None:
        """Take the latest moment; on the session's thread."""
        self._reading = self._watch.look()

    def reading(self) -> NetworkReading:
        """The latest moment."""
        return self._reading

    def toggle_link(self, cell: int, port: int) -> None:
        """Cut the wire at a cell's port, or mend it."""
        self._watch.demand(cell, port)
        self._ask(lambda: self._watch.toggle_link(cell, port))

    def toggle_cell(self, cell: int) -> None:
        """Kill a cell, or start a dead one."""
        self._watch.demand(cell)
        self._ask(lambda: self._watch.toggle_cell(cell))

    def mend(self) -> None:
        """Mend all wires and start all cells."""
        self._ask(self._watch.mend)

    def set_pace(self, pace: float) -> None:
        """Refused: the network's time is the session's."""
        raise NetworkError(f"pace {pace}: a session's network runs in the session's time")
