# SPDX-License-Identifier: Apache-2.0
"""The application's part of the page: what the arms do, what each area feels, and what they are told to do."""

from __future__ import annotations

import queue
import threading
from collections.abc import Callable
from functools import partial

from rich.console import Console

from robotskin.apps.embrace.control import HugControl
from robotskin.apps.embrace.grasp_control import GraspControl
from robotskin.apps.embrace.scene import PERSON
from robotskin.apps.embrace.script import PUSH_N
from robotskin.live.live_session import LiveSession
from robotskin.session import Session
from robotskin.viewer.page import Page
from robotskin.viewer.session_view import Snapshot

Orders = dict[str, Callable[[], object]]
Ask = Callable[[Callable[[], object]], None]
FRAMES_PER_TEXT = 6


class EmbracePage(Page):
    """The page of a session with a folder of its own."""

    def __init__(
        self, session: LiveSession, control: HugControl | GraspControl, orders: Orders, ask: Ask, port: int
    ) -> None:
        self._text = None
        self._control, self._count = control, 0
        super().__init__(session, port)
        with self.server.gui.add_folder("Embrace"):
            self._text = self.server.gui.add_html("")
            for label, order in orders.items():
                self.server.gui.add_button(label).on_click(partial(_asked, ask, order))

    def draw(self, snapshot: Snapshot, now_s: float) -> None:
        """Send one moment to the browsers."""
        super().draw(snapshot, now_s)
        self._count += 1
        if self._text is None or self._count % FRAMES_PER_TEXT:
            return
        control, arms = self._control, self._control.arms
        rows = "".join(
            f"<tr><td>{area}</td><td>{force:.1f} N</td><td>{int(arms.touched[arms.areas.cells[area]].sum())}</td></tr>"
            for area, force in arms.force.items()
        )
        self._text.content = (
            f'<div style="padding:0 12px;font-size:12px" data-embrace="{control.state.name.lower()}">'
            f"<b>{control.state}</b> {control.because}<table><tr><td>area</td><td>feels</td><td>cells</td></tr>{rows}"
            f"</table>largest of one cell {arms.largest_n:.1f} N</div>"
        )


def _asked(ask: Ask, order: Callable[[], object], _event: object) -> None:
    ask(order)


def show_hug(session: Session, regulated: bool, port: int) -> None:
    """Serve the page of a booted session, whose arms begin to hug, until it is interrupted."""
    control = HugControl(session, regulated=regulated)
    person = session.world.thing(PERSON)
    orders: Orders = {
        "Let go": control.release,
        "Hug again": control.restart,
        "Push the person": lambda: person.push((0.0, PUSH_N, 0.0)),
        "Push no more": lambda: person.push((0.0, 0.0, 0.0)),
    }
    _show(session, control, orders, port)


def show_grasp(session: Session, reactive: bool, port: int) -> None:
    """Serve the page of a booted session, whose arms open and wait, until it is interrupted."""
    control = GraspControl(session, reactive=reactive)
    _show(session, control, {"Grasp, or open": control.ask}, port)


def _show(session: Session, control: HugControl | GraspControl, orders: Orders, port: int) -> None:
    console = Console()
    asked: queue.SimpleQueue[Callable[[], object]] = queue.SimpleQueue()

    def after_step() -> None:
        while not asked.empty():
            asked.get()()
        control.step()

    with (
        LiveSession(session, after_step=after_step) as live,
        EmbracePage(live, control, orders, asked.put, port) as page,
    ):
        console.print(f"open [bold]{page.address}[/] (Ctrl-C ends)")
        try:
            threading.Event().wait()
        except KeyboardInterrupt:
            console.print("bringing the robot to rest")
