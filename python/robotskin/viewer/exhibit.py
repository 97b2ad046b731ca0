# SPDX-License-Identifier: Apache-2.0
"""A page without a session: a robot in its skin, to turn around and bend, and its network, to see alive and to cut."""

import numpy as np

from robotskin.layout import Layout
from robotskin.robots import Robot
from robotskin.viewer.cell_card import place_rows
from robotskin.viewer.colours import category_colours
from robotskin.viewer.joint_sliders import joint_sliders
from robotskin.viewer.legend import PADDING, legend
from robotskin.viewer.network import wired_tree
from robotskin.viewer.network_panel import LEGEND, NetworkPanel
from robotskin.viewer.network_scene import NetworkScene, cell_colours
from robotskin.viewer.network_view import NetworkReading, NetworkView
from robotskin.viewer.port_table import port_table
from robotskin.viewer.scene import Scene
from robotskin.viewer.served_page import ServedPage
from robotskin.viewer.session_view import Floats

PATCH, NETWORK = "patch", "network"
WHOLE = "the whole robot"
NEAR_M = 0.6
FRAMES_PER_S = 30
FRAMES_PER_READOUT = 4
NOTHING_CHOSEN = f'<div style="{PADDING};font-size:12px;opacity:.65">Click a cell to see how it is wired.</div>'


class Exhibit(ServedPage):
    """Serves a robot of n joints in the skin `layout` at `address` until `close`.

    `port` is the first one tried; where it is taken the next free one is used, so read `address`. With a living
    `network` its trees are drawn as they grow, and clicks cut wires and kill cells; without, the wired tree is drawn.
    """

    def __init__(
        self,
        robot: Robot,
        layout: Layout,
        port: int = 8080,
        network: NetworkView | None = None,
        posture: Floats | None = None,
    ) -> None:
        """`posture`: (n,) rad or m in which the robot stands at first; by default neutral."""
        self.robot = robot
        self.layout = layout
        self.posture = np.array(robot.neutral if posture is None else posture, dtype=float)
        self.chosen: int | None = None
        super().__init__(f"{robot.name}, {len(layout)} cells", port)
        self._cable, parent = wired_tree(layout)
        self.scene = Scene(self.server, robot, layout, self.posture)
        self.scene.hint("click a cell" if network is None else "click a cell or a wire")
        self.scene.on_cell_click = self._click
        self.network = network
        self.wires: NetworkScene | None = None
        if network is None:
            self.scene.draw_tree(parent)
        else:
            self.wires = NetworkScene(self.scene, layout)
        gui = self.server.gui
        with gui.add_folder("Colour"):
            shown = PATCH if network is None else NETWORK
            self.modality = gui.add_dropdown("Cells by", (PATCH, NETWORK), initial_value=shown)
            self._looked = gui.add_dropdown(
                "Look at",
                (WHOLE, *layout.links),
                initial_value=WHOLE,
                hint="Turn to a link, near enough for its wires to be seen and clicked.",
            )
            self._cables = gui.add_checkbox("Cables", False, visible=bool(layout.cables))
            self._legend = gui.add_html("")
        self.panel = None if network is None else NetworkPanel(self.server, layout, network, self.command)
        if self.wires is not None and self.panel is not None:
            self.wires.on_wire_click = self.panel.click_wire
        with gui.add_folder("Cell"):
            self.card = gui.add_html(NOTHING_CHOSEN)
        with gui.add_folder("Posture", expand_by_default=network is None):
            joint_sliders(self.server, robot, self.posture, self._bend_joint)
        self.modality.on_update(lambda _: self.show())
        self._cables.on_update(lambda _: self.show())
        self._looked.on_update(lambda _: self._look_at(self._looked.value))
        self.show()
        self._start("exhibit")

    def show(self) -> None:
        """Draw the skin in the chosen colours."""
        modality = self.modality.value
        living = modality == NETWORK and self.wires is not None
        self._legend.content = LEGEND if living else legend(modality, self.layout, self._cable)
        if living:
            self.draw_network()
        else:
            self.scene.colour(category_colours(self.layout.patch if modality == PATCH else self._cable))
        if self.wires is not None:
            self.wires.show(living)
        if self.panel is not None:
            self.panel.show(living)
        self.scene.show_tree(modality == NETWORK)
        self.scene.show_cables(self._cables.value)

    def draw_network(self, readout: bool = True) -> None:
        """Draw the network's latest moment; `readout`: its numbers too."""
        if self.network is None or self.wires is None or self.panel is None:
            return
        reading = self.network.reading()
        with self.server.atomic():
            self.scene.colour(cell_colours(reading))
            self.wires.update(reading)
            if readout:
                self.panel.update(reading)
                self._show_card(reading)

    def _run(self) -> None:
        frame = 0
        while self.network is not None and not self._closing.wait(1 / FRAMES_PER_S):
            if not self.server.get_clients():
                continue
            if self.modality.value == NETWORK:
                self.draw_network(readout=frame % FRAMES_PER_READOUT == 0)
            elif frame % FRAMES_PER_READOUT == 0:
                self._show_card(self.network.reading())
            frame += 1

    def bend(self, posture: Floats) -> None:
        """Take a posture (n,), rad or m."""
        self.posture = np.array(posture, dtype=float)
        self.scene.move(self.posture)

    def _click(self, cell: int) -> None:
        self._show_cell(cell)
        network = self.network
        if network is not None and self.panel is not None and self.panel.kills:
            self.command(lambda: network.toggle_cell(cell))

    def _show_cell(self, cell: int) -> None:
        self.chosen = cell
        self.scene.hint("")
        self.scene.mark(cell, None)
        self._show_card(None if self.network is None else self.network.reading())

    def _show_card(self, reading: NetworkReading | None) -> None:
        cell = self.chosen
        if cell is None:
            return
        cable = self._cable if reading is None else reading.cable
        ports = "" if reading is None else port_table(cell, self.layout, reading)
        rows = place_rows(cell, self.layout, cable) + ports
        content = f'<div style="{PADDING};font-size:12px"><b data-cell="{cell}">Cell {cell}</b>{rows}</div>'
        if self.card.content != content:
            self.card.content = content

    def _look_at(self, link: str) -> None:
        if link == WHOLE:
            self.scene.turn_to_all()
            return
        cells = self.layout.cells_on(link)
        # The cell that faces the way in which most of the link's skin does.
        normals = self.layout.link_from_cell[cells, :3, 2]
        self.scene.turn_to(int(cells[np.argmax(normals @ normals.sum(axis=0))]), NEAR_M)

    def _bend_joint(self, joint: int, value: float) -> None:
        posture = self.posture.copy()
        posture[joint] = value
        self.bend(posture)
