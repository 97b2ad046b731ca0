# SPDX-License-Identifier: Apache-2.0
"""The standing robot in the browser: what holds it up is drawn on the floor, and its priorities stand in a list."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from rich.console import Console

from robotskin.control import FEEDFORWARD
from robotskin.live.live_session import LiveSession
from robotskin.session import Session
from robotskin.viewer.page import Page
from robotskin.viewer.session_view import Snapshot

Array = NDArray[np.float64]
FRAMES_PER_TEXT = 6
LIFT_M = 0.004
"""Of what lies on the floor, above it."""
CENTRE, ZMP, CAPTURE, SUPPORT, FLOOR_FORCE = (
    (240, 228, 66),
    (230, 120, 40),
    (86, 180, 233),
    (0, 200, 140),
    (64, 150, 220),
)
FORCE_M_PER_N = 6e-4
RING_M = 0.24
"""Radius of the ring at the height of the centre of mass, which lies inside of the robot."""
FELT_N = 0.3


@dataclass(frozen=True)
class Held:
    """What holds a standing robot up at one moment; world frame, metres and newton."""

    centre: Array
    """(3,) centre of mass."""
    capture: Array
    """(2,) capture point."""
    zmp: Array | None
    """(2,) zero-moment point; None where a foot does not tell its force."""
    corners: Array
    """(K, 2) of the support polygon."""
    inside_m: float
    """How far the capture point is inside of the polygon."""
    pressed: Array
    """(2, 2) where each foot presses; means nothing without its load."""
    load_n: Array | None
    """(2,) of each foot; None where a foot does not tell its force."""


def held(session: Session) -> Held | None:
    """What the controller knows now; None before its first tick."""
    state = session.controller.cycle.standing
    if state is None or len(state.support.corners) < 3:
        return None
    return Held(
        np.array(state.centre_of_mass),
        np.array(state.capture_point),
        np.array(state.zmp) if state.forces_count else None,
        np.array(state.support.corners),
        float(state.support.inside_by(state.capture_point)),
        np.array(state.foot_place) + np.array(state.foot_pressure),
        np.array(state.foot_load_n) if state.forces_count else None,
    )


def priorities(session: Session) -> list[tuple[str, str]]:
    """(level, tasks) of the behaviour, the highest first; what is added without a level last."""
    by_level: dict[int, list[str]] = {}
    for name, level in session.controller.behaviour.tasks.items():
        by_level.setdefault(level, []).append(name.replace("_", " "))
    levels = sorted(level for level in by_level if level != FEEDFORWARD)
    rows = [(str(level), ", ".join(by_level[level])) for level in levels]
    if FEEDFORWARD in by_level:
        rows.append(("+", ", ".join(by_level[FEEDFORWARD])))
    return rows


class BalancePage(Page):
    """The page of a session, with centre of mass, zero-moment point, support polygon and the floor's forces."""

    def __init__(self, live: LiveSession, port: int) -> None:
        self._text = None
        self._count = 0
        self._live = live
        super().__init__(live, port)
        scene = self.server.scene
        nowhere = np.zeros((1, 2, 3))
        self._polygon = scene.add_line_segments("/balance/support", nowhere, SUPPORT, thickness=0.008)
        self._plumb = scene.add_line_segments("/balance/plumb", nowhere, CENTRE, thickness=0.006)
        self._forces = scene.add_arrows(
            "/balance/forces", np.zeros((2, 2, 3)), FLOOR_FORCE, shaft_radius=0.012, head_radius=0.028, head_length=0.06
        )
        around = np.array([(np.cos(angle), np.sin(angle), 0.0) for angle in np.linspace(0, 2 * np.pi, 37)])
        self._ring = scene.add_line_segments(
            "/balance/height", RING_M * np.stack([around[:-1], around[1:]], axis=1), CENTRE, thickness=0.006
        )
        self._spots = {
            name: scene.add_cylinder(f"/balance/{name}", radius=radius, height=0.004, color=colour)
            for name, radius, colour in (("centre", 0.022, CENTRE), ("zmp", 0.018, ZMP), ("capture", 0.014, CAPTURE))
        }
        with self.server.gui.add_folder("Balance", order=-1.0):
            self._text = self.server.gui.add_html("")

    def draw(self, snapshot: Snapshot, now_s: float) -> None:
        """Send one moment to the browsers."""
        super().draw(snapshot, now_s)
        found = held(self._live.session)
        if self._text is None or found is None:
            return
        with self.server.atomic():
            self._draw(found)
            if self._count % FRAMES_PER_TEXT == 0:
                force = snapshot.skin.cell_forces_n()
                self._text.content = self._told(found, float(force[force > FELT_N].sum()))
        self._count += 1

    def _draw(self, found: Held) -> None:
        corners = np.column_stack([found.corners, np.full(len(found.corners), LIFT_M)])
        self._polygon.points = np.stack([corners, np.roll(corners, -1, axis=0)], axis=1).astype(np.float32)
        below = np.array([*found.centre[:2], LIFT_M])
        self._plumb.points = np.array([[below, found.centre]], dtype=np.float32)
        self._forces.visible = found.load_n is not None
        if found.load_n is not None:
            starts = np.column_stack([found.pressed, np.full(2, LIFT_M)])
            # From below, where no leg hides them: the floor pushes the feet up.
            below_feet = starts - np.outer(np.maximum(FORCE_M_PER_N * found.load_n, 0.07), [0.0, 0.0, 1.0])
            self._forces.points = np.stack([below_feet, starts], axis=1).astype(np.float32)
        self._ring.position = found.centre
        places = {"centre": found.centre[:2], "zmp": found.zmp, "capture": found.capture}
        for height, (name, place) in enumerate(places.items()):
            self._spots[name].visible = place is not None
            if place is not None:
                self._spots[name].position = np.array([*place, LIFT_M + 0.003 * height])

    def _told(self, found: Held, felt_n: float) -> str:
        def spot(colour: tuple[int, int, int]) -> str:
            return f'<span style="color:rgb{colour}">●</span>'

        levels = "".join(
            f'<div style="display:flex"><span style="width:20px;opacity:.7">{level}</span><span>{tasks}</span></div>'
            for level, tasks in priorities(self._live.session)
        )
        zmp = "unknown" if found.zmp is None else f"{1e3 * found.zmp[0]:+.0f}, {1e3 * found.zmp[1]:+.0f} mm"
        load = "left unknown, right unknown"
        load_n = ""
        if found.load_n is not None:
            load = f"left {found.load_n[0]:.0f} N, right {found.load_n[1]:.0f} N"
            load_n = f"{found.load_n.sum():.0f}"
        touch = f"touched with {felt_n:.1f} N" if felt_n > 0 else "not touched"
        return (
            f'<div style="padding:0 12px;font-size:12px" data-inside-mm="{1e3 * found.inside_m:.1f}" '
            f'data-felt-n="{felt_n:.1f}" data-load-n="{load_n}">'
            f"{spot(CENTRE)} centre of mass {1e3 * found.centre[0]:+.0f}, {1e3 * found.centre[1]:+.0f} mm<br>"
            f"{spot(ZMP)} zero-moment point {zmp}<br>"
            f"{spot(CAPTURE)} capture point, {1e3 * found.inside_m:.0f} mm inside {spot(SUPPORT)} the soles<br>"
            f"{spot(FLOOR_FORCE)} {load}<br>"
            f'<div style="margin-top:6px"><b>Priorities</b>, the highest first</div>{levels}{touch}</div>'
        )


def show(session: Session, port: int, push: tuple[int, float] | None = None) -> None:
    """Serve the page until it is interrupted; `push`: cell and newton from the beginning. Then bring it to rest."""
    console = Console()
    try:
        with console.status("booting the skin"):
            session.boot()
    except BaseException:
        session.shut_down()
        raise
    with LiveSession(session) as live, BalancePage(live, port) as page:
        if push is not None:
            live.push(*push)
        page.serve(console, "bringing the robot to rest", " and push the robot")
