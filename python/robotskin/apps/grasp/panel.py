# SPDX-License-Identifier: Apache-2.0
"""The application's part of the page: what the hand does, what each finger feels, and what it is told to do."""

from __future__ import annotations

from rich.console import Console

from robotskin.apps.grasp.control import GraspControl
from robotskin.apps.grasp.fingers import NAMES
from robotskin.apps.grasp.scene import PLIERS, believed_shape
from robotskin.apps.grasp.script import LIFT_M, Plan
from robotskin.live.live_session import LiveSession
from robotskin.live.told_page import Orders, ToldPage
from robotskin.session import Session
from robotskin.skin import STANDARD_GRAVITY_MPS2
from robotskin.viewer.session_view import Snapshot


class GraspPage(ToldPage):
    """The page of a session with a folder of its own."""

    def __init__(self, session: LiveSession, control: GraspControl, port: int) -> None:
        self._control = control
        carriage = control.carriage
        orders: Orders = {
            "Lift": lambda: carriage.go(LIFT_M),
            "Lower": lambda: carriage.go(0.0),
            "Shake": lambda: carriage.shake(0.5 * STANDARD_GRAVITY_MPS2, 2.0, 3.0),
            "Let go": control.release,
            "Grasp again": control.restart,
        }
        if control.levers is not None:
            thing = control.session.world.thing(PLIERS)
            orders = {"The holder lets go": thing.let_go, **orders}
        super().__init__(session, "Grasp", port, orders)

    def told(self, snapshot: Snapshot) -> str:
        """The state, and what each finger feels."""
        control = self._control
        rows = "".join(
            f"<tr><td>{name}</td><td>{control.force[finger]:.2f} N</td><td>{_distance(control.near[finger])}</td>"
            f"<td>{control.shares[finger]:.2f}</td></tr>"
            for finger, name in enumerate(NAMES)
        )
        lost = [name for finger, name in enumerate(NAMES) if control.lost[finger]]
        because = f"{control.because}; cells are lost: {', '.join(lost)}" if lost else control.because
        share = "share" if control.levers is None else "wants, N"
        raised_mm = 1e3 * control.carriage.position_m
        return (
            f'<div style="padding:0 12px;font-size:12px" data-grasp="{control.state.name.lower()}">'
            f"<b>{control.state}</b> {because}<p data-raised>raised by {raised_mm:.0f} mm</p><table><tr><td>finger</td>"
            f"<td>feels</td><td>near</td><td>{share}</td></tr>{rows}"
            "</table></div>"
        )


def _distance(metres: float) -> str:
    return f"{1e3 * metres:.0f} mm" if metres < 0.1 else "–"


def show(session: Session, plan: Plan, port: int) -> None:
    """Serve the page of a booted session, whose hand begins to grasp, until it is interrupted."""
    console = Console()
    control = GraspControl(session, believed_shape(plan.name), plan.method)
    with LiveSession(session, after_step=control.step) as live, GraspPage(live, control, port) as page:
        page.serve(console, "bringing the robot to rest")
