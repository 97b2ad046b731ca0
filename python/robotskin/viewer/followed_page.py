# SPDX-License-Identifier: Apache-2.0
"""The page of a robot that is elsewhere: it in its skin as of now, and whether that is still so."""

from __future__ import annotations

from html import escape
from typing import Protocol

from robotskin.layout import Layout
from robotskin.viewer.legend import PADDING
from robotskin.viewer.session_view import Floats, RobotView, SkinReading
from robotskin.viewer.skin_page import FRAMES_PER_S, SkinPage


class FollowedView(Protocol):
    """A robot that is elsewhere. `posture`: (n,) rad or m as last heard."""

    @property
    def robot(self) -> RobotView:
        """What moves."""

    @property
    def layout(self) -> Layout:
        """What feels."""

    @property
    def posture(self) -> Floats:
        """(n,) rad or m as last heard."""

    def reading(self) -> SkinReading | None:
        """What was felt last, no cell alive where that is not fresh; None: nothing was heard yet."""

    def told(self) -> str:
        """Whether the link lives, in a sentence."""


class FollowedPage(SkinPage):
    """Serves a robot that is elsewhere at `address` until `close`."""

    def __init__(self, view: FollowedView, title: str, port: int = 8080) -> None:
        super().__init__(view.robot, view.layout, view.posture, title, port)
        self.view = view
        with self.server.gui.add_folder("Link"):
            self.link = self.server.gui.add_html("")
        self._add_skin_folders()
        self._start("followed page")

    def _run(self) -> None:
        while not self._closing.wait(1 / FRAMES_PER_S):
            if not self.server.get_clients():
                continue
            reading = self.view.reading()
            with self.server.atomic():
                if reading is None or self.draw_skin(self.view.posture, reading):
                    told = f'<div style="{PADDING};font-size:12px" data-link>{escape(self.view.told())}</div>'
                    if self.link.content != told:
                        self.link.content = told
