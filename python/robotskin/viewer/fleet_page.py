# SPDX-License-Identifier: Apache-2.0
"""The page of a monitor: a table of all robots of a fleet, and stop."""

from __future__ import annotations

import threading
from collections.abc import Callable, Sequence
from html import escape

from robotskin.errors import RobotskinError
from robotskin.fleet.table import HEADINGS, Row
from robotskin.viewer.legend import PADDING
from robotskin.viewer.own_page import NO_SCENE
from robotskin.viewer.served_page import ServedPage

REFRESH_S = 0.2
NONE = "no robot yet"
GRID = "display:grid;grid-template-columns:repeat(auto-fill,minmax(19em,1fr));gap:10px"
CARD = "border:1px solid #444;border-radius:4px;padding:6px 10px"
LEFT = "opacity:.65;padding-right:8px;white-space:nowrap;vertical-align:top"


class FleetPage(ServedPage):
    """Serves a fleet at `address` until `close`.

    Args:
        rows: what is to be shown as of now. stop: stops a robot, or all where the name is None, and tells how it went;
        None: this member may stop none.
    """

    def __init__(
        self,
        rows: Callable[[], Sequence[Row]],
        stop: Callable[[str | None], str] | None,
        title: str,
        port: int = 8080,
    ) -> None:
        super().__init__(title, port, NO_SCENE)
        self._rows, self._stop = rows, stop
        gui = self.server.gui
        if stop is not None:  # before all that grows, so that it is never out of sight
            self.all = gui.add_button("STOP ALL", color="red")
            self.robot = gui.add_dropdown("Robot", (NONE,), initial_value=NONE)
            self.one = gui.add_button("Stop this robot", color="orange")
            self.answer = gui.add_html("")
            self.one.on_click(lambda _: self._stopped(self.robot.value))
            self.all.on_click(lambda _: self._stopped(None))
        self.table = gui.add_html("")
        self._start("fleet page")

    def _stopped(self, name: str | None) -> None:
        if self._stop is not None and name != NONE:
            # Not in the page's thread: it waits for the robots' answers, and the next click must not wait for it.
            threading.Thread(target=self._answer, args=(self._stop, name), daemon=True).start()

    def _answer(self, stop: Callable[[str | None], str], name: str | None) -> None:
        try:
            told = stop(name)
        except RobotskinError as error:
            told = str(error)
        self.answer.content = f'<div style="{PADDING};font-size:12px" data-answer>{escape(told)}</div>'

    def _run(self) -> None:
        while not self._closing.wait(REFRESH_S):
            if not self.server.get_clients():
                continue
            rows = self._rows()
            text = rows_html(rows)
            if self.table.content != text:
                self.table.content = text
            names = tuple(row.name for row in rows) or (NONE,)
            if self._stop is not None and tuple(self.robot.options) != names:
                self.robot.options = names


def rows_html(rows: Sequence[Row]) -> str:
    """The table, a row a robot in lines of its own; what is not fresh is faded. Texts of robots are escaped."""
    if not rows:
        return f'<div style="{PADDING};font-size:13px">no robot is in the fleet: robotskin run ROBOT --fleet FILE</div>'
    parts = []
    for row in rows:
        lines = "".join(
            f'<tr><td style="{LEFT}">{heading}</td><td>{escape(text)}</td></tr>'
            for heading, text in zip(HEADINGS[1:], row.cells[1:], strict=True)
        )
        faded = "" if row.fresh else "opacity:.55;"
        parts.append(
            f'<div style="{faded}{CARD}" data-robot="{escape(row.name)}" data-fresh="{row.fresh}">'
            f"<b>{escape(row.name)}</b><table>{lines}</table></div>"
        )
    return f'<div style="{PADDING};font-size:13px;{GRID}">{"".join(parts)}</div>'
