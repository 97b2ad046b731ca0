# SPDX-License-Identifier: Apache-2.0
"""The measuring half of the page: what the session does right now, and the last seconds of touch and motion."""

from collections import deque
from html import escape

import numpy as np
import viser
from viser import uplot

from robotskin.layout import Layout
from robotskin.viewer.cell_card import cell_card, table_rows
from robotskin.viewer.legend import PADDING
from robotskin.viewer.network_view import NetworkReading
from robotskin.viewer.session_view import Health, Integers, RobotView, Snapshot

HISTORY_S = 12.0
PLOT_POINTS = 240
ROUND_NUMBERS = (5.0, 10.0, 20.0, 50.0, 100.0, 200.0, 500.0, 1000.0, 2000.0)

# Name of a statistic, what the page calls it, how it is written.
TILES = (
    ("realtime_factor", "real time", "{:.2f}×"),
    ("frames_per_s", "frames/s", "{:,.0f}"),
    ("datagrams_per_s", "datagrams/s", "{:,.0f}"),
    ("driver_cpu_percent", "driver CPU", "{:.1f} %"),
    ("frames_lost", "frames lost", "{:,.0f}"),
    ("fallback_ticks", "ticks that fell back", "{:,.0f}"),
)
TILE_STYLE = "background:rgba(128,140,160,.13);border-radius:6px;padding:4px 8px"


class History:
    """The last seconds of the force on a cell and of how far it was moved, at most `PLOT_POINTS` of each."""

    def __init__(self) -> None:
        self._points: deque[tuple[float, float, float]] = deque(maxlen=PLOT_POINTS)

    def add(self, time_s: float, force_n: float, displacement_m: float) -> None:
        """Append a moment; one that is not later than the last is skipped, or starts anew where time ran backwards."""
        if self._points and time_s < self._points[-1][0]:
            self._points.clear()
        if not self._points or time_s - self._points[-1][0] >= HISTORY_S / PLOT_POINTS:
            self._points.append((time_s, force_n, displacement_m))

    def columns(self) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """Seconds before now, newton, millimetres, each (K,) with K at least 2."""
        points = np.array(self._points if len(self._points) > 1 else [(0.0, 0.0, 0.0)] * 2)
        return points[:, 0] - points[-1, 0], points[:, 1], points[:, 2] * 1e3


class Readouts:
    """Fills the panel on the left; `update` is called a few times a second."""

    def __init__(self, server: viser.ViserServer, robot: RobotView, layout: Layout) -> None:
        self.robot = robot
        self.layout = layout
        self.history = History()
        panel = server.gui.add_panel()
        with panel.add_tab("Live", viser.Icon.ACTIVITY):
            self._state = server.gui.add_html("")
            self._force = _Plot(server, "Force on the cell [N]", "#ffb454")
            self._displacement = _Plot(server, "Displacement of the cell [mm]", "#40c4ff")
        with panel.add_tab("Cell", viser.Icon.HEXAGON):
            self._cell = server.gui.add_html("")
        with panel.add_tab("Joints", viser.Icon.ROBOT):
            self._joints = server.gui.add_html("")
        panel.dock_left()
        panel.set_width(300)

    def update(
        self,
        snapshot: Snapshot,
        cell: int | None,
        cable: Integers,
        silent_s: float,
        network: NetworkReading | None = None,
    ) -> None:
        """Show a moment that is `silent_s` seconds old, and the chosen cell; what is at its ports is `network`'s."""
        _assign(self._state, state_tiles(snapshot, silent_s))
        _assign(self._cell, cell_card(cell, self.layout, cable, snapshot.skin, network))
        _assign(self._joints, joint_rows(list(self.robot.joint_names), snapshot))

    def update_plots(self) -> None:
        """Draw the history anew."""
        seconds, force, displacement = self.history.columns()
        self._force.show(seconds, force)
        self._displacement.show(seconds, displacement)


def state_tiles(snapshot: Snapshot, silent_s: float = 0.0) -> str:
    """The controller's state and the statistics as HTML; `silent_s` seconds ago the session gave its last sign."""
    trouble = snapshot.stop_reason or (f"no news for {silent_s:.0f} s: all numbers are old" if silent_s > 0 else "")
    colour = "#ff6b5e" if trouble else "#34c38f"
    skin = "skin on" if snapshot.skin_on else "skin off"
    detail = trouble or f"{snapshot.interface} interface, {snapshot.mode} mode, {skin}"
    behaviour = escape(snapshot.behaviour)
    does = f'<span style="font-weight:400;opacity:.8"> · {behaviour.replace("_", " ")}</span>' if behaviour else ""
    head = (
        f'<div style="{TILE_STYLE};border-left:3px solid {colour};margin-bottom:6px" '
        f'data-interface="{escape(snapshot.interface)}" data-mode="{escape(snapshot.mode)}">'
        f'<div style="font-weight:600" data-controller="{escape(snapshot.controller_state)}" '
        f'data-behaviour="{behaviour}">{escape(snapshot.controller_state)}{does}</div>'
        f'<div style="font-size:12px;opacity:.8">{escape(detail)}</div></div>'
    )
    alive = int(np.count_nonzero(np.asarray(snapshot.skin.health) == list(Health).index(Health.ALIVE)))
    tiles = [("cells alive", f"{alive} / {len(snapshot.skin.health)}")]
    tiles += [
        (title, form.format(snapshot.statistics[name])) for name, title, form in TILES if name in snapshot.statistics
    ]
    cells = "".join(
        f'<div style="{TILE_STYLE}"><div style="font-size:11px;opacity:.65">{escape(title)}</div>'
        f'<div style="font-variant-numeric:tabular-nums">{escape(value)}</div></div>'
        for title, value in tiles
    )
    grid = f'<div style="display:grid;grid-template-columns:1fr 1fr;gap:6px">{cells}</div>'
    return f'<div style="{PADDING}">{head}{grid}</div>'


def joint_rows(joint_names: list[str], snapshot: Snapshot) -> str:
    """The joint positions as HTML; each number is also in the attribute `data-joint-position`."""
    positions = np.asarray(snapshot.joint_position, dtype=float)
    attributes = " ".join(f"{position:.5f}" for position in positions)
    rows = [(name, f"{position:+.4f}") for name, position in zip(joint_names, positions, strict=True)]
    positions_html = f'<div data-joint-positions="{attributes}">{table_rows(rows)}</div>'
    return f'<div style="{PADDING};font-size:12px">{positions_html}{torque_table(joint_names, snapshot)}</div>'


def torque_table(joint_names: list[str], snapshot: Snapshot) -> str:
    """What host and skin say that touch asks of each joint, side by side, as HTML; empty where only the host does."""
    torques = snapshot.torques
    if torques is None:
        return ""
    state = f"{torques.cells} cells summed" if torques.fresh else "nothing new"
    head = f"Torque of touch, used: {snapshot.source}; the skin's: {state}"
    columns = "".join(f'<td style="text-align:right;opacity:.65">{name}</td>' for name in ("host", "skin"))
    rows = "".join(
        f"<tr><td>{escape(name)}</td>"
        + "".join(
            f'<td style="text-align:right;font-variant-numeric:tabular-nums">{value:+.2f}</td>'
            for value in (host, skin)
        )
        + "</tr>"
        for name, host, skin in zip(joint_names, torques.host, torques.skin, strict=True)
    )
    return (
        f'<div style="margin-top:8px" data-torque-source="{escape(snapshot.source)}">{escape(head)}</div>'
        f'<table style="width:100%"><tr><td></td>{columns}</tr>{rows}</table>'
    )


class _Plot:
    """One line over the last seconds, on an axis from 0 to the next round number above it."""

    def __init__(self, server: viser.ViserServer, title: str, colour: str) -> None:
        axis = uplot.Axis(stroke="#9aa5b5", grid={"stroke": "rgba(140,150,170,.18)", "width": 1}, size=40)
        self._top = ROUND_NUMBERS[0]
        self._handle = server.gui.add_uplot(
            (np.zeros(2), np.zeros(2)),
            (uplot.Series(label="s"), uplot.Series(label=title, stroke=colour, width=1.6, fill=colour + "22")),
            title=title,
            scales=self._scales(),
            axes=(axis, axis),
            legend=uplot.Legend(show=False),
            cursor=uplot.Cursor(show=False),
            height=150,
            padding=(8, 12, 0, 0),
        )

    def show(self, seconds: np.ndarray, values: np.ndarray) -> None:
        """Draw values (K,) over seconds (K,)."""
        top = next((number for number in ROUND_NUMBERS if number >= values.max()), ROUND_NUMBERS[-1])
        if top != self._top:
            self._top = top
            self._handle.scales = self._scales()
        self._handle.data = (seconds, values)

    def _scales(self) -> dict[str, uplot.Scale]:
        return {"x": uplot.Scale(time=False, range=(-HISTORY_S, 0.0)), "y": uplot.Scale(range=(0.0, self._top))}


def _assign(handle: viser.GuiHtmlHandle, content: str) -> None:
    if handle.content != content:
        handle.content = content
