# SPDX-License-Identifier: Apache-2.0
"""The page of a live session with a folder of an application: a text, and buttons for what may be asked of it."""

from __future__ import annotations

from abc import abstractmethod
from collections.abc import Callable, Mapping
from functools import partial
from typing import Any

from robotskin.live.live_session import LiveSession
from robotskin.viewer.page import Page
from robotskin.viewer.session_view import Snapshot

__all__ = ["Orders", "ToldPage"]

Orders = Mapping[str, Callable[[], object]]
"""By the label of a button, what is done on the session's thread."""
FRAMES_PER_TEXT = 6


class ToldPage(Page):
    """Shows what `told` says, some times a second."""

    def __init__(self, live: LiveSession, folder: str, port: int, orders: Orders | None = None) -> None:
        self._text: Any = None
        self._count = 0
        super().__init__(live, port)
        with self.server.gui.add_folder(folder):
            self._text = self.server.gui.add_html("")
            for label, order in (orders or {}).items():
                self.server.gui.add_button(label).on_click(partial(self._asked, partial(live.ask, order)))

    def _asked(self, ask: Callable[[], None], _event: object) -> None:
        self.command(ask)

    def draw(self, snapshot: Snapshot, now_s: float) -> None:
        """Send one moment to the browsers."""
        super().draw(snapshot, now_s)
        self._count += 1
        if self._text is not None and self._count % FRAMES_PER_TEXT == 0:
            self._text.content = self.told(snapshot)

    @abstractmethod
    def told(self, snapshot: Snapshot) -> str:
        """The folder's text, as HTML."""
