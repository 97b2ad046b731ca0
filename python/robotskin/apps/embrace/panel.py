# SPDX-License-Identifier: Apache-2.0
"""The application's part of the page: what the arms do, what each area feels, and what they are told to do."""

from __future__ import annotations

from rich.console import Console

from robotskin.apps.balance.panel import BalancePage
from robotskin.apps.embrace.arms import Paths
from robotskin.apps.embrace.control import HugControl
from robotskin.apps.embrace.grasp_control import GraspControl
from robotskin.apps.embrace.grasp_scene import TABLE, Large, sinking
from robotskin.apps.embrace.scene import PERSON
from robotskin.apps.embrace.script import PUSH_N
from robotskin.live.live_session import LiveSession
from robotskin.live.told_page import Orders, ToldPage
from robotskin.session import Session
from robotskin.viewer.session_view import Snapshot


class EmbracePage(ToldPage, BalancePage):
    """The page of a session with a folder of its own, and with the balance of a robot that stands."""

    def __init__(
        self, session: LiveSession, control: HugControl | GraspControl, orders: Orders, port: int, handed: str = ""
    ) -> None:
        self._control, self._handed = control, handed
        super().__init__(session, "Embrace", port, orders)

    def told(self, snapshot: Snapshot) -> str:
        """The state, and what each area feels."""
        control, arms = self._control, self._control.arms
        rows = "".join(
            f"<tr><td>{area}</td><td>{force:.1f} N</td><td>{int(arms.touched[arms.areas.cells[area]].sum())}</td></tr>"
            for area, force in arms.force.items()
        )
        return (
            f'<div style="padding:0 12px;font-size:12px" data-embrace="{control.state.name.lower()}">'
            f"<b>{control.state}</b> {control.because}<table><tr><td>area</td><td>feels</td><td>cells</td></tr>{rows}"
            f"</table>largest of one cell {arms.largest_n:.1f} N"
            + (f"<br>handed: {self._handed}" if self._handed else "")
            + "</div>"
        )


def show_hug(session: Session, regulated: bool, port: int) -> None:
    """Serve the page of a booted session, whose arms begin to hug, until it is interrupted."""
    control = HugControl(session, regulated=regulated)
    person = session.world.thing(PERSON)

    def push_no_more() -> None:
        person.push((0.0, 0.0, 0.0))

    def let_go() -> None:
        """The push ends, too: what nothing holds it would carry aside, to where no arms find it."""
        push_no_more()
        control.release()

    def hug_again() -> None:
        push_no_more()
        control.restart()

    orders: Orders = {
        "Let go": let_go,
        "Hug again": hug_again,
        "Push the person": lambda: person.push((0.0, PUSH_N, 0.0)),
        "Push no more": push_no_more,
    }
    _show(session, control, orders, port)


def show_grasp(session: Session, large: Large, reactive: bool, taught: Paths | None, port: int) -> None:
    """Serve the page of a booted session, whose arms open and wait, until it is interrupted."""
    control = GraspControl(session, around=taught, reactive=reactive)
    table = session.world.thing(TABLE)
    orders: Orders = {
        "Grasp, or open": control.ask,
        "Let the table sink": lambda: table.follow(sinking(large, control.arms.arms)),
    }
    _show(session, control, orders, port, large.told)


def _show(session: Session, control: HugControl | GraspControl, orders: Orders, port: int, handed: str = "") -> None:
    console = Console()
    with (
        LiveSession(session, after_step=control.step) as live,
        EmbracePage(live, control, orders, port, handed) as page,
    ):
        page.serve(console, "bringing the robot to rest")
