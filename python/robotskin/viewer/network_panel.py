# SPDX-License-Identifier: Apache-2.0
"""The panel of a living network: how to meddle with it, how fast its time goes, and what each cable carries."""

from collections.abc import Callable

import numpy as np
import viser

from robotskin.layout import Layout
from robotskin.viewer.cell_card import table_rows
from robotskin.viewer.colours import NO_FRESH_VALUE, category_colours
from robotskin.viewer.legend import PADDING, STYLE, css, swatch
from robotskin.viewer.network import cable_names, fair_shares
from robotskin.viewer.network_scene import CUT_COLOUR, DAMAGED_COLOUR, DEAD_COLOUR, IDLE_COLOUR, MOVED_COLOUR
from robotskin.viewer.network_view import PACES, NetworkReading, NetworkView

LOOK, KILL = "only looks", "kills or starts a cell"
CUT, DISTURB = "cuts or mends it", "makes it damage frames"
MEANING = "Cells and wires have the colour of the cable that they report through, as in the bars below"
LEGEND = (
    f'<div style="{STYLE}"><div style="margin-bottom:4px">{MEANING}</div>'
    + " ".join(
        swatch(colour, text)
        for colour, text in (
            (MOVED_COLOUR, "new path"),
            (CUT_COLOUR, "cut"),
            (DAMAGED_COLOUR, "damages frames"),
            (IDLE_COLOUR, "spare wire"),
            (NO_FRESH_VALUE, "no way out"),
            (DEAD_COLOUR, "dead or no power"),
        )
    )
    + "</div>"
)
HINT = "A cable is clicked at its post."


class NetworkPanel:
    """Fills a folder. `command(action)` runs what a person asked for and reports what it refuses."""

    def __init__(
        self,
        server: viser.ViserServer,
        layout: Layout,
        network: NetworkView,
        command: Callable[[Callable[[], None]], None],
        pace: str = "10 times slower",
    ) -> None:
        self.layout = layout
        self._network = network
        self._command = command
        gui = server.gui
        with gui.add_folder("Network") as self.folder:
            self.tool = gui.add_dropdown(
                "A click on a cell", (LOOK, KILL), initial_value=LOOK, hint="A cell that is killed sends nothing."
            )
            self.wire_tool = gui.add_dropdown("A click on a wire", (CUT, DISTURB), initial_value=CUT, hint=HINT)
            self.pace = gui.add_dropdown(
                "Slow motion",
                tuple(PACES),
                initial_value=pace,
                visible=network.paced,
                hint="A network heals in milliseconds: only in slow motion can it be watched.",
            )
            self.mend = gui.add_button("Mend everything", icon=viser.Icon.TOOL, color="gray")
            self._state = gui.add_html("")
        self.pace.on_update(lambda _: command(lambda: network.set_pace(PACES[self.pace.value])))
        self.mend.on_click(lambda _: command(network.mend))

    @property
    def kills(self) -> bool:
        """Whether a click on a cell kills it, or starts it."""
        return self.tool.value == KILL

    def click_wire(self, cell: int, port: int) -> None:
        """Do to the wire at a cell's port what the chosen tool does."""
        do = self._network.disturb_link if self.wire_tool.value == DISTURB else self._network.toggle_link
        self._command(lambda: do(cell, port))

    def show(self, shown: bool) -> None:
        """Show the folder, or hide it."""
        if self.folder.visible != shown:
            self.folder.visible = shown

    def update(self, reading: NetworkReading) -> None:
        """Show a moment."""
        content = state(reading, self.layout)
        if self._state.content != content:
            self._state.content = content


def state(reading: NetworkReading, layout: Layout) -> str:
    """What the network does, and the cells that each cable carries beside the fair share, as HTML.

    The attributes `data-stranded` and `data-loads` hold the numbers.
    """
    names = cable_names(layout)
    cables = len(names)
    load = reading.load(cables)
    fair = fair_shares(reading.alive, reading.cut, layout)
    reached = int(np.count_nonzero(reading.cable >= 0))
    most = int(max(load.max(initial=1), fair.max(initial=1)))
    colour = "#ff6b5e" if reading.stranded else "#34c38f"
    rows = [
        ("time", f"{reading.time_s * 1e3:,.1f} ms"),
        ("cells with a way out", f"{reached} / {len(layout)}"),
        ("longest way to a unit", f"{int(reading.hops.max(initial=0))} hops"),
        ("cells that do not run, cut wires", f"{int(np.count_nonzero(~reading.alive))}, {_wires_cut(reading, layout)}"),
        ("damaged frames", f"{int(reading.damaged.sum()):,}"),
    ]
    bars = "".join(_bar(index, names[index], int(load[index]), int(fair[index]), most) for index in range(cables))
    loads = " ".join(str(count) for count in load)
    return (
        f'<div style="{PADDING};font-size:12px" data-stranded="{reading.stranded}" data-loads="{loads}">'
        f'<div style="border-left:3px solid {colour};padding-left:8px;margin-bottom:6px;font-weight:600">'
        f"{reading.news}</div>{table_rows(rows)}"
        '<div style="opacity:.75;margin-top:6px">Cells on each cable (section unit:port); the line: a fair share</div>'
        f'<div style="max-height:260px;overflow-y:auto">{bars}</div></div>'
    )


def _bar(index: int, name: str, load: int, fair: int, most: int) -> str:
    colour = css(category_colours(np.array([index]))[0]) if fair else "rgb(255,70,60)"
    scale = 100 / most
    bar = f"position:absolute;inset:0;width:{load * scale:.1f}%;background:{colour};border-radius:3px"
    mark = f"position:absolute;left:{fair * scale:.1f}%;top:-2px;bottom:-2px;width:1px;background:#fff9"
    ground = "position:relative;flex:1;height:9px;background:rgba(128,140,160,.18);border-radius:3px"
    number = "width:34px;text-align:right;font-variant-numeric:tabular-nums"
    return (
        '<div style="display:flex;align-items:center;gap:6px;line-height:1.5">'
        f'<span style="width:34px;opacity:.65;font-variant-numeric:tabular-nums">{name}</span>'
        f'<span style="{ground}"><span style="{bar}"></span><span style="{mark}"></span></span>'
        f'<span style="{number}">{load if fair else "cut"}</span></div>'
    )


def _wires_cut(reading: NetworkReading, layout: Layout) -> int:
    ports = np.count_nonzero(reading.cut)
    between_cells = np.count_nonzero(reading.cut & (layout.neighbours[:, :, 0] >= 0))
    return int(ports - between_cells // 2)
