# SPDX-License-Identifier: Apache-2.0
"""The browser page of a session: scene, controls and readouts on a server bound to this machine.

A thread of its own copies the session's state thirty times a second and sends what changed; the control loop never
waits for it, and while no browser looks it only asks whether one came.
"""

import time
from dataclasses import replace

import numpy as np

from robotskin.skin import Health
from robotskin.viewer.colours import cell_colours
from robotskin.viewer.controls import APPROACH, PUSH, Controls
from robotskin.viewer.network import follow, wired_tree
from robotskin.viewer.network_panel import NetworkPanel
from robotskin.viewer.network_scene import NetworkScene
from robotskin.viewer.network_scene import cell_colours as network_colours
from robotskin.viewer.readouts import Readouts
from robotskin.viewer.scene import Scene
from robotskin.viewer.served_page import ServedPage
from robotskin.viewer.session_view import SessionView, Snapshot, StoppedByHand
from robotskin.viewer.solids import Solids

__all__ = ["Page"]

FRAMES_PER_S = 30
FRAMES_PER_READOUT = 6
FRAMES_PER_PLOT = 4
DRAG_NEWTON_PER_METRE = 200.0
SILENCE_S = 1.5
FELT_N = 0.3
MARKED_COLOUR = (255, 0, 200)


class Page(ServedPage):
    """Serves `session` at `address` from construction to `close`; any number of browsers may look.

    `port` is the first one tried; where it is taken the next free one is used, so read `address`.
    """

    def __init__(self, session: SessionView, port: int = 8080) -> None:
        super().__init__(session.title, port)
        self.session = session
        self.chosen: int | None = None
        snapshot = session.snapshot()
        self.scene = Scene(self.server, session.robot, session.layout, snapshot.joint_position)
        self.solids = Solids(self.server, session.solids)
        self._cable, self._parent = wired_tree(session.layout)
        self.controls = Controls(self.server, session, self._cable, self.command)
        self.wires, self.panel = self._network_parts()
        self.readouts = Readouts(self.server, session.robot, session.layout)
        self.scene.draw_tree(self._parent)
        self.scene.hint(
            "touch the skin; click a cell to see its numbers"
            if isinstance(session, StoppedByHand)
            else "click a cell to push it"
        )
        self.controls.turn.on_click(lambda _: self._turn())
        self.scene.on_cell_click = self._click
        self.scene.on_cell_drag = self._drag
        self.scene.on_hand_drag = self._drag_hand
        self._rest: tuple[int, np.ndarray] | None = None
        self._drawn = 0
        self._last = (-np.inf, 0.0)
        self._start("viewer")

    # What a person does ---------------------------------------------------------------------------------------------

    def _network_parts(self) -> tuple[NetworkScene | None, NetworkPanel | None]:
        network = self.session.network
        if network is None:
            return None, None
        wires = NetworkScene(self.scene, self.session.layout)
        wires.show(False)
        panel = NetworkPanel(self.server, self.session.layout, network, self.command)
        wires.on_wire_click = panel.click_wire
        panel.show(False)
        return wires, panel

    def _turn(self) -> None:
        if self.chosen is not None:
            self.scene.turn_to(self.chosen)

    def _choose(self, cell: int) -> None:
        if self.chosen is None:
            self.scene.hint("")
            self.controls.turn.visible = True
        self.chosen = cell

    def _click(self, cell: int) -> None:
        self._choose(cell)
        network = self.session.network
        if network is not None and self.panel is not None and self.panel.kills and self.controls.modality == "network":
            self.command(lambda: network.toggle_cell(cell))
        elif self.controls.tool == PUSH:
            force, duration = float(self.controls.force.value), self.controls.duration_s
            self.command(lambda: self.session.push(cell, force, duration))
        elif self.controls.tool == APPROACH:
            distance = float(self.controls.distance.value) / 100
            self.command(lambda: self.session.approach(cell, distance))

    def _drag(self, cell: int, phase: str, length_m: float) -> None:
        self._choose(cell)
        if phase == "end":
            self.command(self.session.release)
        elif self.controls.tool == PUSH:
            force = min(DRAG_NEWTON_PER_METRE * length_m, self.controls.force.max)
            if force > 0:
                self.command(lambda: self.session.push(cell, force))

    def _drag_hand(self, distance_m: float, done: bool) -> None:
        cell = self.chosen
        if cell is None:
            return
        self.command(lambda: self.session.approach(cell, distance_m))
        if done:
            self.controls.show_distance(distance_m)

    # What the session does ------------------------------------------------------------------------------------------

    def _run(self) -> None:
        period = 1 / FRAMES_PER_S
        due = time.monotonic()
        while not self._closing.wait(max(0.0, due - time.monotonic())):
            # A late frame is left out, not made up for.
            due = max(due + period, time.monotonic())
            if self.server.get_clients():
                self.draw(self.session.snapshot(), time.monotonic())

    def draw(self, snapshot: Snapshot, now_s: float) -> None:
        """Send one moment to the browsers; `now_s` is the wall clock's, of any origin.

        A session whose time has stood still for `SILENCE_S` is shown as what it is: no cell has a fresh value.
        """
        if snapshot.time_s != self._last[0]:
            self._last = (snapshot.time_s, now_s)
        silent_s = now_s - self._last[1]
        if silent_s < SILENCE_S:
            silent_s = 0.0
        else:
            stale = np.full(len(self.session.layout), Health.stale.value)
            snapshot = replace(snapshot, skin=replace(snapshot.skin, health=stale))
        with self.server.atomic():
            self.scene.move(snapshot.joint_position)
            self._colour(snapshot)
            self.scene.mark(self.chosen if snapshot.marked is None else snapshot.marked, snapshot.touch)
            self.scene.show_hands(snapshot.hands)
            if snapshot.solids is not None:
                self.solids.move(snapshot.solids)
            self._follow_network(snapshot)
            self._remember(snapshot)
            if self._drawn % FRAMES_PER_READOUT == 0:
                network = self.session.network
                reading = None if network is None or self.chosen is None else network.reading()
                self.readouts.update(snapshot, self.chosen, self._cable, silent_s, reading)
                self.controls.update(snapshot, now_s)
                self.scene.name(self._name_of_chosen(snapshot))
            if self._drawn % FRAMES_PER_PLOT == 0:
                self.readouts.update_plots()
        self._drawn += 1

    def _colour(self, snapshot: Snapshot) -> None:
        network = self.session.network
        if self.controls.modality != "network" or network is None or self.wires is None or self.panel is None:
            colours = cell_colours(self.controls.modality, self.session.layout, self._cable, snapshot.skin)
            if snapshot.marked is not None:
                colours[snapshot.marked] = MARKED_COLOUR
            self.scene.colour(colours)
            return
        reading = network.reading()
        self.scene.colour(network_colours(reading))
        self.wires.update(reading)
        if self._drawn % FRAMES_PER_READOUT == 0:
            self.panel.update(reading)

    def _name_of_chosen(self, snapshot: Snapshot) -> str:
        if snapshot.marked is not None:
            return f"touch cell {snapshot.marked}"
        cell = snapshot.touch.cell if snapshot.touch is not None else self.chosen
        if cell is None:
            return ""
        force = float(np.sum(snapshot.skin.normal_force[cell]))
        return f"cell {cell}: {force:.1f} N" if force > FELT_N else f"cell {cell}"

    def _follow_network(self, snapshot: Snapshot) -> None:
        """Take over the tree that the cells have grown, where it is known and has changed."""
        if snapshot.parent is not None and not np.array_equal(snapshot.parent, self._parent):
            self._parent = np.array(snapshot.parent)
            self._cable = follow(self._parent, self.session.layout)
            self.scene.draw_tree(self._parent)
            self.controls.show_legend(self._cable)
        shown = self.controls.modality == "network"
        self.scene.show_tree(shown and self.wires is None)
        if self.wires is not None and self.panel is not None:
            self.wires.show(shown)
            self.panel.show(shown)
        self.scene.show_cables(self.controls.cables)

    def _remember(self, snapshot: Snapshot) -> None:
        """Keep the chosen cell's force, and its way from where it was before it was touched."""
        if self.chosen is None:
            return
        position = self.scene.cell_position(self.chosen)
        if self._rest is None or self._rest[0] != self.chosen:
            self._rest = (self.chosen, position)
        force = float(np.sum(snapshot.skin.normal_force[self.chosen]))
        displacement = float(np.linalg.norm(position - self._rest[1]))
        self.readouts.history.add(snapshot.time_s, force, displacement)
