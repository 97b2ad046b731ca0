# SPDX-License-Identifier: Apache-2.0
"""The standing robot in the browser: its balance is drawn around it, and told in a folder of the panel."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray
from rich.console import Console

from robotskin.apps.balance.floor_map import CAPTURE, CENTRE, FLOOR_FORCE, SUPPORT, ZMP, Colour, floor_map
from robotskin.apps.balance.held import FELT_N, Held, Touched, held, priorities, touched
from robotskin.live.live_session import LiveSession
from robotskin.session import Session, SkinnedRobot
from robotskin.viewer.page import Page
from robotskin.viewer.scene import Scene
from robotskin.viewer.session_view import Snapshot

Array = NDArray[np.float64]
FRAMES_PER_TEXT = 6
LIFT_M = 0.004
"""Of what lies on the floor, above it."""
TOUCH: Colour = (235, 110, 175)
FOOT_M_PER_N, TOUCH_M_PER_N = 6e-4, 1e-2
LEAST_ARROW_M = 0.07
TOUCH_GAP_M = 0.07
"""Between the skin and the tip of an arrow, so that it hides neither the hand nor the cells that feel it."""
HAND_OPACITY = 0.6
"""A hand is small beside a humanoid: it must be seen from where the whole robot is."""
RING_M = 0.24
"""Radius of the ring at the height of the centre of mass, which lies inside of the robot."""


class BalanceDrawing:
    """Centre of mass, zero-moment point, support polygon, the forces on feet and skin, and the active priorities.

    Args:
        scene: of the page. session: whose robot stands. note: HTML under the priorities, such as what is simulated.

    `look` is called on the session's thread, `draw` on the page's.
    """

    def __init__(self, scene: Scene, session: SkinnedRobot, note: str = "") -> None:
        self._found: Held | None = None
        self._scene, self._session, self._note = scene, session, note
        self._count = 0
        draw = scene.server.scene
        nowhere = np.zeros((1, 2, 3))
        self._polygon = draw.add_line_segments("/balance/support", nowhere, SUPPORT, thickness=0.008)
        self._plumb = draw.add_line_segments("/balance/plumb", nowhere, CENTRE, thickness=0.006)
        self._forces = draw.add_arrows(
            "/balance/forces", np.zeros((2, 2, 3)), FLOOR_FORCE, shaft_radius=0.012, head_radius=0.028, head_length=0.06
        )
        self._touches = draw.add_arrows(
            "/balance/touches", nowhere, TOUCH, shaft_radius=0.009, head_radius=0.02, head_length=0.045, visible=False
        )
        around = np.array([(np.cos(angle), np.sin(angle), 0.0) for angle in np.linspace(0, 2 * np.pi, 37)])
        self._ring = draw.add_line_segments(
            "/balance/height", RING_M * np.stack([around[:-1], around[1:]], axis=1), CENTRE, thickness=0.006
        )
        self._spots = {
            name: draw.add_cylinder(f"/balance/{name}", radius=radius, height=0.004, color=colour)
            for name, radius, colour in (("centre", 0.022, CENTRE), ("zmp", 0.018, ZMP), ("capture", 0.014, CAPTURE))
        }
        with scene.server.gui.add_folder("Balance", order=-1.0):
            self._text = scene.server.gui.add_html("")

    def look(self) -> None:
        """Keep what holds the robot up at this moment."""
        self._found = held(self._session)

    def draw(self, snapshot: Snapshot) -> None:
        """Send one moment to the browsers."""
        found = self._found
        if found is None:
            return
        force_n = snapshot.skin.cell_forces_n()
        parts: list[Touched] = []
        if (force_n > FELT_N).any():
            parts = touched(self._scene.layout, self._scene.cell_poses(), force_n)
        self._draw(found, parts)
        for hand in self._scene.hands:
            if hand.opacity != HAND_OPACITY:
                hand.opacity = HAND_OPACITY
        if self._count % FRAMES_PER_TEXT == 0:
            self._text.content = self._told(found, parts, float(force_n[force_n > FELT_N].sum()))
        self._count += 1

    def _draw(self, found: Held, parts: Sequence[Touched]) -> None:
        corners = np.column_stack([found.corners, np.full(len(found.corners), LIFT_M)])
        self._polygon.points = np.stack([corners, np.roll(corners, -1, axis=0)], axis=1).astype(np.float32)
        below = np.array([*found.centre[:2], LIFT_M])
        self._plumb.points = np.array([[below, found.centre]], dtype=np.float32)
        self._forces.visible = found.force is not None
        if found.force is not None:
            # Their tips are at the soles, and they come from below, where no leg hides them.
            tips = np.column_stack([found.pressed, np.full(2, LIFT_M)])
            self._forces.points = arrows(tips, FOOT_M_PER_N * found.force)
        self._touches.visible = bool(parts)
        if parts:
            tips, forces = np.array([one.place for one in parts]), np.array([one.force for one in parts])
            self._touches.points = arrows(tips, TOUCH_M_PER_N * forces, TOUCH_GAP_M)
        self._ring.position = found.centre
        places = {"centre": found.centre[:2], "zmp": found.zmp, "capture": found.capture}
        for height, (name, place) in enumerate(places.items()):
            self._spots[name].visible = place is not None
            if place is not None:
                self._spots[name].position = np.array([*place, LIFT_M + 0.003 * height])

    def _told(self, found: Held, parts: Sequence[Touched], felt_n: float) -> str:
        def spot(colour: Colour) -> str:
            return f'<span style="color:rgb{colour}">●</span>'

        levels = "".join(
            f'<div style="display:flex"><span style="width:20px;opacity:.7">{level}</span><span>{tasks}</span></div>'
            for level, tasks in priorities(self._session)
        )
        zmp = "unknown" if found.zmp is None else f"{1e3 * found.zmp[0]:+.0f}, {1e3 * found.zmp[1]:+.0f} mm"
        load_n = "" if found.force is None else f"{found.force[:, 2].sum():.0f}"
        return (
            f'<div style="padding:0 12px;font-size:12px" data-inside-mm="{1e3 * found.inside_m:.1f}" '
            f'data-felt-n="{felt_n:.1f}" data-load-n="{load_n}">{floor_map(found)}'
            f"{spot(CENTRE)} centre of mass {1e3 * found.centre[0]:+.0f}, {1e3 * found.centre[1]:+.0f} mm<br>"
            f"{spot(ZMP)} zero-moment point {zmp}<br>"
            f"{spot(CAPTURE)} capture point, {1e3 * found.inside_m:.0f} mm inside {spot(SUPPORT)} the soles<br>"
            f"{_wrenches(found, parts)}"
            f'<div style="margin-top:6px"><b>Priorities</b>, the highest first</div>{levels}{self._note}</div>'
        )


def arrows(tips: Array, forces_m: Array, gap_m: float = 0.0) -> NDArray[np.float32]:
    """(K, 2, 3) m, starts and ends: each ends `gap_m` before its tip (K, 3) and is as long as its force (K, 3), but not
    too short. A force of nothing points up.
    """
    length = np.linalg.norm(forces_m, axis=1, keepdims=True)
    along = np.where(length > 1e-9, forces_m / np.maximum(length, 1e-9), [0.0, 0.0, 1.0])
    tips = tips - gap_m * along
    return np.stack([tips - np.maximum(length, LEAST_ARROW_M) * along, tips], axis=1).astype(np.float32)


def _wrenches(found: Held, parts: Sequence[Touched]) -> str:
    """A table, HTML: what presses on the feet and on each touched link."""

    def row(colour: Colour, name: str, *cells: str) -> str:
        told = "".join(f'<td style="text-align:right">{cell}</td>' for cell in cells)
        return f'<tr><td><span style="color:rgb{colour}">●</span> {name}</td>{told}</tr>'

    rows = []
    for index, foot in enumerate(("left foot", "right foot")):
        if found.force is None or found.moment is None:
            rows.append(row(FLOOR_FORCE, foot, "unknown", "unknown"))
        else:
            rows.append(row(FLOOR_FORCE, foot, _vector(found.force[index], 0), _vector(found.moment[index], 1)))
    rows += [row(TOUCH, one.link.removesuffix("_link").replace("_", " "), _vector(one.force, 0)) for one in parts]
    if not parts:
        rows.append('<tr><td colspan="3">the skin is not touched</td></tr>')
    return (
        '<table style="margin-top:6px;width:100%;font-size:11px;white-space:nowrap" data-wrenches>'
        '<tr><td>contact</td><td style="text-align:right">force x y z, N</td>'
        f'<td style="text-align:right">moment, Nm</td></tr>{"".join(rows)}</table>'
    )


def _vector(values: Array, digits: int) -> str:
    # Zero has no sign.
    return " ".join(f"{round(float(value), digits) + 0.0:.{digits}f}" for value in values)


class BalancePage(Page):
    """The page of a session, with the balance of a robot that stands; of a mounted one it is a page like any other."""

    def __init__(self, live: LiveSession, port: int, note: str = "") -> None:
        """`note`: HTML that stands under the priorities."""
        self._balance: BalanceDrawing | None = None
        super().__init__(live, port)
        if live.session.robot.standing is not None:
            self._balance = BalanceDrawing(self.scene, live.session, note)
            live.look_with_snapshots(self._balance.look)

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
