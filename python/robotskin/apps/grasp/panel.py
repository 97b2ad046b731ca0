# SPDX-License-Identifier: Apache-2.0
"""The application's part of the page: what the hand does, what each finger feels, and what it is told to do."""

from __future__ import annotations

import queue
import threading
from collections.abc import Callable
from functools import partial

from rich.console import Console

from robotskin.apps.grasp.control import GraspControl
from robotskin.apps.grasp.fingers import NAMES
from robotskin.apps.grasp.scene import believed_shape
from robotskin.apps.grasp.script import GRAVITY, LIFT_M, Plan
from robotskin.live.live_session import LiveSession
from robotskin.session import Session
from robotskin.viewer.page import Page
from robotskin.viewer.session_view import Snapshot

Ask = Callable[[Callable[[], object]], None]
FRAMES_PER_TEXT = 6


class GraspPage(Page):
    """The page of a session with a folder of its own."""

    def __init__(self, session: LiveSession, control: GraspControl, ask: Ask, port: int) -> None:
        self._text = None
        self._control, self._count = control, 0
        super().__init__(session, port)
        carriage = control.carriage
        orders: dict[str, Callable[[], object]] = {
            "Lift": lambda: carriage.go(LIFT_M),
            "Lower": lambda: carriage.go(0.0),
            "Shake": lambda: carriage.shake(0.5 * GRAVITY, 2.0, 3.0),
            "Let go": control.release,
            "Grasp again": control.restart,
        }
        with self.server.gui.add_folder("Grasp"):
            self._text = self.server.gui.add_html("")
            for label, order in orders.items():
                self.server.gui.add_button(label).on_click(partial(_asked, ask, order))

    def draw(self, snapshot: Snapshot, now_s: float) -> None:
        """Send one moment to the browsers."""
        super().draw(snapshot, now_s)
        self._count += 1
        if self._text is None or self._count % FRAMES_PER_TEXT:
            return
        control = self._control
        rows = "".join(
            f"<tr><td>{name}</td><td>{control.force[finger]:.2f} N</td><td>{_distance(control.near[finger])}</td>"
            f"<td>{control.shares[finger]:.2f}</td></tr>"
            for finger, name in enumerate(NAMES)
        )
        self._text.content = (
            f'<div style="padding:0 12px;font-size:12px" data-grasp="{control.state.name.lower()}">'
            f"<b>{control.state}</b><table><tr><td>finger</td><td>feels</td><td>near</td><td>share</td></tr>{rows}"
            "</table></div>"
        )


def _asked(ask: Ask, order: Callable[[], object], _event: object) -> None:
    ask(order)


def _distance(metres: float) -> str:
    return f"{1e3 * metres:.0f} mm" if metres < 0.1 else "–"


def show(session: Session, plan: Plan, port: int) -> None:
    """Serve the page of a booted session, whose hand begins to grasp, until it is interrupted."""
    console = Console()
    control = GraspControl(session, believed_shape(plan.name), plan.method)
    orders: queue.SimpleQueue[Callable[[], object]] = queue.SimpleQueue()

    def after_step() -> None:
        while not orders.empty():
            orders.get()()
        control.step()

    with LiveSession(session, after_step=after_step) as live, GraspPage(live, control, orders.put, port) as page:
        console.print(f"open [bold]{page.address}[/] (Ctrl-C ends)")
        try:
            threading.Event().wait()
        except KeyboardInterrupt:
            console.print("bringing the robot to rest")
