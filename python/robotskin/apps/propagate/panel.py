# SPDX-License-Identifier: Apache-2.0
"""The application's part of the page: what the robot does, and how far its base is from its place."""

from __future__ import annotations

from rich.console import Console

from robotskin.apps.propagate.script import BaseWay, Plan, felt_n
from robotskin.apps.propagate.states import Seen, State, following
from robotskin.live.live_session import LiveSession
from robotskin.live.told_page import ToldPage
from robotskin.session import Session
from robotskin.viewer.session_view import Snapshot


class PropagatePage(ToldPage):
    """The page of a session with a folder of its own."""

    def __init__(self, session: LiveSession, port: int) -> None:
        self._state = State.WAITING
        self._way_m = self._felt_n = 0.0
        self._way = BaseWay(session.session)
        self._near_n = float(session.session.gains.values["skin"]["proximity_n"])
        super().__init__(session, "Propagation", port)

    def draw(self, snapshot: Snapshot, now_s: float) -> None:
        """Send one moment to the browsers."""
        self._way_m = self._way.metres(snapshot.joint_position)
        self._felt_n = felt_n(snapshot.skin.cell_forces_n(), snapshot.skin.cell_nearness(), self._near_n)
        self._state = following(self._state, Seen(self._felt_n, self._way_m))
        super().draw(snapshot, now_s)

    def told(self, snapshot: Snapshot) -> str:
        """The state, how far the base is from its place, and what is felt."""
        way_mm = 1e3 * self._way_m
        return (
            f'<div style="padding:0 12px;font-size:12px" data-propagation="{self._state.name.lower()}" '
            f'data-base-mm="{way_mm:.1f}"><b>{self._state}</b><br>base {way_mm:.0f} mm from its place, '
            f"{self._felt_n:.1f} N felt</div>"
        )


def show(session: Session, port: int, plan: Plan | None = None) -> None:
    """Serve the page of a booted session until it is interrupted; a plan's cell is pushed from the beginning."""
    console = Console()
    with LiveSession(session) as live, PropagatePage(live, port) as page:
        if plan is not None:
            live.push(plan.cell, plan.force_n)
        page.serve(console, "bringing the robot to rest")
