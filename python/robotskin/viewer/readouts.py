# SPDX-License-Identifier: Apache-2.0
"""The measuring half of the page: what the session does right now, and the last seconds of touch and motion."""

from collections import deque
from html import escape

import numpy as np
import viser
from viser import uplot

from robotskin.figures import share_told
from robotskin.layout import Layout
from robotskin.skin import Health
from robotskin.viewer.cell_card import cell_card, table_rows
from robotskin.viewer.joint_sliders import shown_unit
from robotskin.viewer.legend import PADDING
from robotskin.viewer.network_view import NetworkReading
from robotskin.viewer.session_view import Integers, RobotView, Snapshot

HISTORY_S = 12.0
PLOT_POINTS = 240
ROUND_NUMBERS = (5.0, 10.0, 20.0, 50.0, 100.0, 200.0, 500.0, 1000.0, 2000.0)

# Name of a statistic, what the page calls it, how it is written, what it means.
TILES = (
    (
        "realtime_factor",
        "speed",
        "{:.2f} × real",
        "How fast the simulated robot's time goes: 1.00 is real time. Less, and this computer is too busy.",
    ),
)
DATA_TILES = (
    ("frames_per_s", "frames per second", "{:,.0f}", "Messages of cells that arrive."),
    ("datagrams_per_s", "datagrams per second", "{:,.0f}", "Network packets that carry them."),
    ("driver_cpu_percent", "driver, of one core", "{:.1f} %", "Processor time that unpacking them takes."),
    ("frames_lost", "frames lost", "{:,.0f}", "Messages that left a cell and never arrived."),
    (
        "intervention_share",
        "commands changed",
        "{:.2%}",
        "Share of the commands that the guard changed to keep a limit of the robot.",
    ),
    (
        "fallback_ticks",
        "solver cut short",
        "{:,.0f}",
        "Ticks in which the solver ran out of steps: limits and the highest priorities were kept.",
    ),
    (
        "widened_ticks",
        "too weak to brake",
        "{:,.0f}",
        "Ticks in which no torque of the motors kept all limits: those of torque were kept, braking came short.",
    ),
)
ALIVE_MEANS = "Cells that send fresh values."
NO_TOUCH_YET = "Click a cell of the robot: its force and its way are drawn here."
LEFT_WIDTH = 272
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
        with panel.add_tab("Now"):
            self._state = server.gui.add_html("")
            self._invitation = server.gui.add_html(
                f'<div style="{PADDING};font-size:13px;opacity:.75">{NO_TOUCH_YET}</div>'
            )
            self._force = _Plot(server, "Force on the cell [N]", "#ffb454")
            self._displacement = _Plot(server, "Way of the cell [mm]", "#40c4ff")
        with panel.add_tab("Cell"):
            self._cell = server.gui.add_html("")
        with panel.add_tab("Joints"):
            self._joints = server.gui.add_html("")
        with panel.add_tab("Data"):
            self._data = server.gui.add_html("")
        panel.dock_left()
        panel.set_width(LEFT_WIDTH)

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
        _assign(self._joints, joint_rows(self.robot, snapshot))
        _assign(self._data, data_tiles(snapshot))
        chosen = cell is not None
        if self._invitation.visible == chosen:
            self._invitation.visible = not chosen
            self._force.visible = self._displacement.visible = chosen

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
    detail = trouble or f"motors obey {snapshot.interface}, {snapshot.mode} mode, {skin}"
    behaviour = escape(snapshot.behaviour)
    does = f'<span style="font-weight:400;opacity:.8"> · {behaviour.replace("_", " ")}</span>' if behaviour else ""
    head = (
        f'<div style="{TILE_STYLE};border-left:3px solid {colour};margin-bottom:6px" '
        f'data-interface="{escape(snapshot.interface)}" data-mode="{escape(snapshot.mode)}">'
        f'<div style="font-weight:600" data-controller="{escape(snapshot.controller_state)}" '
        f'data-behaviour="{behaviour}">{escape(snapshot.controller_state)}{does}</div>'
        f'<div style="font-size:12px;opacity:.8">{escape(detail)}</div></div>'
    )
    alive = int(np.count_nonzero(np.asarray(snapshot.skin.health) == Health.alive.value))
    tiles = [("cells alive", f"{alive} / {len(snapshot.skin.health)}", ALIVE_MEANS)]
    return f'<div style="{PADDING}">{head}{_grid(tiles + _tiles(TILES, snapshot))}{held_back(snapshot)}</div>'


def held_back(snapshot: Snapshot) -> str:
    """Which limits changed commands so far, as HTML; empty where none did."""
    share = snapshot.statistics.get("intervention_share", 0.0)
    if not snapshot.held_back or share <= 0:
        return ""
    return (
        f'<div style="{TILE_STYLE};margin-top:6px;font-size:12px" data-held-back="{share:.6f}">'
        f"The guard changed {share_told(share)} of the commands: {escape(snapshot.held_back)}.</div>"
    )


def data_tiles(snapshot: Snapshot) -> str:
    """What flows between skin and controller, as HTML."""
    return f'<div style="{PADDING}">{_grid(_tiles(DATA_TILES, snapshot))}</div>'


def _tiles(wanted: tuple[tuple[str, str, str, str], ...], snapshot: Snapshot) -> list[tuple[str, str, str]]:
    return [
        (title, form.format(snapshot.statistics[name]), means)
        for name, title, form, means in wanted
        if name in snapshot.statistics
    ]


def _grid(tiles: list[tuple[str, str, str]]) -> str:
    cells = "".join(
        f'<div style="{TILE_STYLE}" title="{escape(means)}"><div style="font-size:11.5px;opacity:.75">{escape(title)}'
        f'</div><div style="font-variant-numeric:tabular-nums">{escape(value)}</div></div>'
        for title, value, means in tiles
    )
    return f'<div style="display:grid;grid-template-columns:1fr 1fr;gap:6px">{cells}</div>'


def joint_rows(robot: RobotView, snapshot: Snapshot) -> str:
    """The joint positions as HTML, in degrees and millimetres; in rad and m in the attribute `data-joint-positions`."""
    joint_names = list(robot.joint_names)
    positions = np.asarray(snapshot.joint_position, dtype=float)
    attributes = " ".join(f"{position:.5f}" for position in positions)
    units = [shown_unit(slides) for slides in robot.joint_slides]
    rows = [
        (name, f"{factor * position:+.1f}{unit if unit == '°' else ' ' + unit}")
        for name, position, (unit, factor) in zip(joint_names, positions, units, strict=True)
    ]
    positions_html = f'<div data-joint-positions="{attributes}">{table_rows(rows)}</div>'
    return f'<div style="{PADDING};font-size:12px">{positions_html}{torque_table(joint_names, snapshot)}</div>'


def torque_table(joint_names: list[str], snapshot: Snapshot) -> str:
    """What host and skin say that touch asks of each joint, side by side, as HTML; empty where only the host does."""
    torques = snapshot.torques
    if torques is None:
        return ""
    state = f"the cells summed {torques.cells}" if torques.fresh else "the cells sent nothing new"
    used = {"host": "this computer's", "skin": "the cells'"}.get(snapshot.source, snapshot.source)
    head = f"Torque of touch [Nm]; used: {used}; {state}"
    columns = "".join(
        f'<td style="text-align:right;opacity:.75">{name}</td>' for name in ("this computer", "the cells")
    )
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
        time = uplot.Axis(**axis, label="seconds from now", labelSize=16, labelGap=0, labelFont="12px sans-serif")
        self._top = ROUND_NUMBERS[0]
        self._handle = server.gui.add_uplot(
            (np.zeros(2), np.zeros(2)),
            (uplot.Series(label="s"), uplot.Series(label=title, stroke=colour, width=1.6, fill=colour + "22")),
            title=title,
            scales=self._scales(),
            axes=(time, axis),
            legend=uplot.Legend(show=False),
            cursor=uplot.Cursor(show=False),
            height=166,
            padding=(8, 12, 0, 0),
            visible=False,
        )

    @property
    def visible(self) -> bool:
        """Whether it is drawn."""
        return self._handle.visible

    @visible.setter
    def visible(self, shown: bool) -> None:
        self._handle.visible = shown

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
