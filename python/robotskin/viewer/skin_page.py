# SPDX-License-Identifier: Apache-2.0
"""A page that shows one robot in its skin and asks nothing of it: colours, and a card of the cell that is clicked."""

from __future__ import annotations

from robotskin.layout import Layout
from robotskin.viewer.cell_card import place_rows
from robotskin.viewer.colours import MODALITIES, cell_colours
from robotskin.viewer.legend import PADDING, legend
from robotskin.viewer.network import wired_tree
from robotskin.viewer.scene import Scene
from robotskin.viewer.served_page import ServedPage
from robotskin.viewer.session_view import Floats, RobotView, SkinReading

FRAMES_PER_S = 30
FRAMES_PER_READOUT = 4
NOTHING_CHOSEN = f'<div style="{PADDING};font-size:12px;opacity:.65">Click a cell to see what it felt.</div>'


class SkinPage(ServedPage):
    """Serves a robot in its skin at `address` until `close`; what derives from it shows moments by `draw_skin`.

    Args:
        posture: (n,) rad or m at first. port: the first one tried.
    """

    def __init__(self, robot: RobotView, layout: Layout, posture: Floats, title: str, port: int) -> None:
        super().__init__(title, port)
        self.chosen: int | None = None
        self._robot, self._layout = robot, layout
        self.scene = Scene(self.server, robot, layout, posture)
        self.scene.hint("click a cell")
        self.scene.on_cell_click = self._click
        self._cable, _ = wired_tree(layout)
        self._drawn = 0

    def _add_skin_folders(self) -> None:
        """Below the folders of what derives from it."""
        gui = self.server.gui
        with gui.add_folder("Colour"):
            self.modality = gui.add_dropdown("Cells by", MODALITIES, initial_value=MODALITIES[0])
            self._legend = gui.add_html("")
        with gui.add_folder("Cell"):
            self.card = gui.add_html(NOTHING_CHOSEN)
        self.modality.on_update(lambda _: self._show_legend())
        self._show_legend()

    def draw_skin(self, posture: Floats, skin: SkinReading) -> bool:
        """Send one moment to the browsers; whether texts are due, too."""
        self.scene.move(posture)
        self.scene.colour(cell_colours(self.modality.value, self._layout, self._cable, skin))
        self.scene.mark(self.chosen, None)
        due = self._drawn % FRAMES_PER_READOUT == 0
        self._drawn += 1
        if due and self.chosen is not None:
            card = self._card(self.chosen, skin)
            if self.card.content != card:
                self.card.content = card
        return due

    def _click(self, cell: int) -> None:
        self.chosen = cell
        self.scene.hint("")

    def _show_legend(self) -> None:
        self._legend.content = legend(self.modality.value, self._layout, self._cable)

    def _card(self, cell: int, skin: SkinReading) -> str:
        rows = place_rows(cell, self._layout, self._cable)
        force, near = float(skin.normal_force[cell].sum()), float(skin.proximity[cell])
        told = {"force": f"force {force:.2f} N", "proximity": f"proximity {near:.2f}"}
        felt = f"<div>{', '.join(text for sensor, text in told.items() if sensor in skin.sensors)}</div>"
        return f'<div style="{PADDING};font-size:12px"><b data-cell="{cell}">Cell {cell}</b>{felt}{rows}</div>'
