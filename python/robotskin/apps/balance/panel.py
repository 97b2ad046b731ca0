# SPDX-License-Identifier: Apache-2.0
"""The standing robot in the browser: what holds it up is drawn on the floor, and its priorities stand in a list."""

from __future__ import annotations

from rich.console import Console

from robotskin.apps.balance.drawing import BalanceDrawing
from robotskin.live.live_session import LiveSession
from robotskin.session import Session
from robotskin.viewer.page import Page
from robotskin.viewer.session_view import Snapshot


class BalancePage(Page):
    """The page of a session, with the balance of a robot that stands; of a mounted one it is a page like any other."""

    def __init__(self, live: LiveSession, port: int, note: str = "") -> None:
        """`note`: HTML that stands under the priorities."""
        self._balance: BalanceDrawing | None = None
        super().__init__(live, port)
        if live.session.robot.standing is not None:
            self._balance = BalanceDrawing(self.scene, live.session, note)

    def draw(self, snapshot: Snapshot, now_s: float) -> None:
        """Send one moment to the browsers."""
        super().draw(snapshot, now_s)
        if self._balance is not None:
            with self.server.atomic():
                self._balance.draw(snapshot)


def show(session: Session, port: int, push: tuple[int, float] | None = None, note: str = "") -> None:
    """Serve the page until it is interrupted; `push`: cell and newton from the beginning. Then bring it to rest."""
    console = Console()
    try:
        with console.status("booting the skin"):
            session.boot()
    except BaseException:
        session.shut_down()
        raise
    with LiveSession(session) as live, BalancePage(live, port, note) as page:
        if push is not None:
            live.push(*push)
            page.scene.hint("")
        page.serve(console, "bringing the robot to rest", " and push the robot")
