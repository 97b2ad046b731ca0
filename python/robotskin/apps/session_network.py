"""The cells' network of a running session, to look at and to meddle with while the robot moves."""

from __future__ import annotations

from collections.abc import Callable

from robotskin.apps.network_watch import NetworkError, NetworkWatch
from robotskin.apps.watched_network import WatchedNetwork


class SessionNetwork(WatchedNetwork):
    """The `robotskin.viewer.network_view.NetworkView` of a session; `ask` hands a request to the session's thread."""

    paced = False

    def __init__(self, watch: NetworkWatch, ask: Callable[[Callable[[], object]], None]) -> None:
        super().__init__(watch)
        self._hand_over = ask

    def _ask(self, request: Callable[[], None]) -> None:
        self._hand_over(request)

    def set_pace(self, pace: float) -> None:
        """Refused: the network's time is the session's."""
        raise NetworkError(f"pace {pace}: a session's network runs in the session's time")
