"""A page without a session: a robot in its skin, to turn around, to bend, and to see how it is laid and wired."""

import numpy as np
import viser

from robotskin.layout import Layout
from robotskin.robots import Robot
from robotskin.viewer.cell_card import place_rows
from robotskin.viewer.colours import category_colours
from robotskin.viewer.legend import PADDING, legend
from robotskin.viewer.network import wired_tree
from robotskin.viewer.scene import Scene
from robotskin.viewer.server import address, close_server, open_server
from robotskin.viewer.session_view import Floats

MODALITIES = ("patch", "network")
NOTHING_CHOSEN = f'<div style="{PADDING};font-size:12px;opacity:.65">Click a cell to see how it is wired.</div>'


class Exhibit:
    """Serves a robot of n joints in the skin `layout` at `address` until `close`.

    `port` is the first one tried; where it is taken the next free one is used, so read `address`.
    """

    def __init__(self, robot: Robot, layout: Layout, port: int = 8080) -> None:
        self.robot = robot
        self.layout = layout
        self.posture = robot.neutral.copy()
        self.server = open_server(f"{robot.name}, {len(layout)} cells", port)
        self.address = address(self.server)
        self._cable, parent = wired_tree(layout)
        self.scene = Scene(self.server, robot, layout, self.posture)
        self.scene.draw_tree(parent)
        self.scene.on_cell_click = self._show_cell
        gui = self.server.gui
        with gui.add_folder("Colour"):
            self.modality = gui.add_dropdown("Cells by", MODALITIES, initial_value="patch")
            self._cables = gui.add_checkbox("Cables", False, visible=bool(layout.cables))
            self._legend = gui.add_html("")
        with gui.add_folder("Cell"):
            self.card = gui.add_html(NOTHING_CHOSEN)
        with gui.add_folder("Posture"):
            self._joints = [self._joint_slider(joint) for joint in range(robot.joint_count)]
        self.modality.on_update(lambda _: self.show())
        self._cables.on_update(lambda _: self.show())
        self.show()

    def __enter__(self) -> "Exhibit":
        return self

    def __exit__(self, *_: object) -> None:
        self.close()

    def close(self) -> None:
        """Stop serving."""
        close_server(self.server)

    def show(self) -> None:
        """Draw the skin in the chosen colours."""
        modality = self.modality.value
        self._legend.content = legend(modality, self.layout, self._cable)
        self.scene.colour(category_colours(self.layout.patch if modality == "patch" else self._cable))
        self.scene.show_tree(modality == "network")
        self.scene.show_cables(self._cables.value)

    def bend(self, posture: Floats) -> None:
        """Take a posture (n,), rad or m."""
        self.posture = np.array(posture, dtype=float)
        self.scene.move(self.posture)

    def _show_cell(self, cell: int) -> None:
        self.scene.mark(cell, None)
        rows = place_rows(cell, self.layout, self._cable)
        self.card.content = f'<div style="{PADDING};font-size:12px"><b>Cell {cell}</b>{rows}</div>'

    def _joint_slider(self, joint: int) -> viser.GuiSliderHandle[float]:
        lower = float(np.maximum(self.robot.lower[joint], -np.pi))
        upper = float(np.minimum(self.robot.upper[joint], np.pi))
        name = self.robot.joint_names[joint].removesuffix("_joint").replace("_", " ")
        slider = self.server.gui.add_slider(name, lower, upper, 0.01, float(self.posture[joint]))

        @slider.on_update
        def _(_: viser.GuiEvent) -> None:
            posture = self.posture.copy()
            posture[joint] = slider.value
            self.bend(posture)

        return slider
