# SPDX-License-Identifier: Apache-2.0
"""What is so in a simulated cell network from one look to the next, what happened, and hands that cut and mend it."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from robotskin import simulator as core
from robotskin.errors import RobotskinError
from robotskin.layout import Layout
from robotskin.layout.cell_network import CellNetwork
from robotskin.viewer.network import follow_ports
from robotskin.viewer.network_view import NO_PATH, NetworkReading
from robotskin.world.trial import wiring_of

NOISE_RATE = 0.002
"""Of the bits of a disturbed wire that flip: one frame in four is damaged."""
NOISE_MS = 100


class NetworkError(RobotskinError):
    """Something asked of a network that it cannot do; the message names the value and the valid choices."""


class NetworkWatch:
    """Looks at the network of the N cells of `layout`, and meddles with it; `clock` tells its time in seconds.

    All but `demand` runs on the thread that steps the network.
    """

    def __init__(self, network: core.Network, layout: Layout, clock: Callable[[], float]) -> None:
        self.network = network
        self.clock = clock
        self.layout = layout
        self._cut = np.zeros((len(layout), 4), dtype=bool)
        self._moved_s = np.full(len(layout), -np.inf)
        self._changes = np.zeros(len(layout), dtype=np.int64)
        self._damaged = np.zeros((len(layout), 4), dtype=int)
        self._damaged_s = np.full((len(layout), 4), -np.inf)
        self._killed = np.zeros(len(layout), dtype=bool)
        self._starting = np.zeros(len(layout), dtype=bool)  # told to start, but not up yet
        self._what = self._news = "power on"
        self._broken_since_s: float | None = self.clock()
        self._stranded_most = 0
        self._lost = self._lost_before = 0

    @property
    def broken(self) -> bool:
        """Whether the network is still mending what last befell it."""
        return self._broken_since_s is not None

    def look(self) -> NetworkReading:
        """The network as it is now."""
        survey = self.network.survey()
        alive = survey["alive"].astype(bool)
        parent_port = np.where(alive, survey["parent_port"], 0).astype(int)
        cable = follow_ports(parent_port, alive, self._cut, self.layout)
        changes = survey["parent_changes"].astype(np.int64)
        self._moved_s[changes != self._changes] = self.clock()
        self._changes = changes
        damaged = survey["damaged"].astype(int)
        self._damaged_s[damaged > self._damaged] = self.clock()
        self._damaged = damaged
        reachable = alive & (np.asarray(self.network.depths) >= 0)
        self._starting &= ~alive
        stranded = int(np.count_nonzero((reachable & (cable == NO_PATH)) | self._starting))
        # A cut cable feeds no cell: cells that only it fed are off.
        self._lost = int(np.count_nonzero(~reachable & ~self._killed & ~self._starting))
        self._tell(stranded, reachable=int(np.count_nonzero(reachable)))
        return NetworkReading(
            time_s=self.clock(),
            parent_port=parent_port,
            cable=cable,
            hops=np.where(cable == NO_PATH, 0, survey["hops"]).astype(int),
            alive=alive,
            cut=self._cut.copy(),
            damaged=damaged,
            moved_s=self._moved_s.copy(),
            damaged_s=self._damaged_s.copy(),
            stranded=stranded,
            news=self._news,
        )

    def demand(self, cell: int, port: int = 1) -> None:
        """Raises NetworkError unless there is such a port of such a cell; any thread may ask."""
        if not 0 <= cell < len(self.layout) or not 1 <= port <= 4:
            raise NetworkError(f"cell {cell}, port {port}: there are cells 0 to {len(self.layout) - 1}, ports 1 to 4")

    def demand_wire(self, cell: int, port: int) -> None:
        """Raises NetworkError unless a wire is at that port of that cell; any thread may ask."""
        self.demand(cell, port)
        plugged = any((place.cell, place.cell_port) == (cell, port) for place in self.layout.section_unit_ports)
        if not plugged and self.layout.neighbours[cell, port - 1, 0] < 0:
            raise NetworkError(f"cell {cell}, port {port}: no wire is there")

    def disturb_link(self, cell: int, port: int) -> None:
        """Let the wire at a cell's port damage frames for 100 ms of the network's time."""
        self.demand_wire(cell, port)
        begin_ns = round(1e9 * self.clock()) + 1000
        text = f"noise:cell={cell},port={port},rate={NOISE_RATE},for={NOISE_MS}ms@{begin_ns}ns"
        (fault,) = core.parse_faults(text, wiring_of(CellNetwork.of_layout(self.layout)), 0)
        self.network.inject(fault)
        self._news = f"wire damages frames for {NOISE_MS} ms"

    def toggle_link(self, cell: int, port: int) -> None:
        """Cut the wire at a cell's port, or mend it."""
        self.demand(cell, port)
        other, other_port = (int(part) for part in self.layout.neighbours[cell, port - 1])
        cut = not self._cut[cell, port - 1]
        if cut:
            self.network.cut(cell, port)
        else:
            self.network.mend(cell, port)
        self._cut[cell, port - 1] = cut
        if other >= 0:
            self._cut[other, other_port - 1] = cut
        self._befell("wire cut" if cut else "wire mended")

    def toggle_cell(self, cell: int) -> None:
        """Kill a cell, or start a dead one."""
        self.demand(cell)
        if self.network.alive(cell):
            self.network.kill(cell)
            self._killed[cell] = True
            self._befell(f"cell {cell} killed")
        elif not self._killed[cell]:
            self._befell(f"cell {cell} has no power, and cannot be started")
        else:
            self._start(cell)
            self._befell(f"cell {cell} started")

    def mend(self) -> None:
        """Mend all wires and start all cells."""
        for cell, port in np.argwhere(self._cut):
            self.network.mend(int(cell), int(port) + 1)
        self._cut[:] = False
        for cell in range(len(self.layout)):
            if not self.network.alive(cell):
                self._start(cell)
        self._befell("all mended")

    def _start(self, cell: int) -> None:
        self.network.reboot(cell)
        self._killed[cell], self._starting[cell] = False, True

    def _befell(self, what: str) -> None:
        self._what = self._news = what
        self._stranded_most = 0
        self._lost_before = self._lost
        self._broken_since_s = self.clock()

    def _tell(self, stranded: int, reachable: int) -> None:
        if self._broken_since_s is None:
            return
        self._stranded_most = max(self._stranded_most, stranded)
        if stranded:
            self._news = f"{self._what}: {_cells(stranded)} without a path"
        elif not reachable:
            self._news = f"{self._what}: no cell can be reached"
        else:
            took_ms = (self.clock() - self._broken_since_s) * 1e3
            lost = self._lost - self._lost_before
            whole = f"whole after {took_ms:.1f} ms" if self._stranded_most else "no other path changes"
            self._news = f"{self._what}: {whole}" + (f", {_cells(lost)} beyond reach of a cable" if lost > 0 else "")
            self._broken_since_s = None


def _cells(count: int) -> str:
    return f"{count} cell" if count == 1 else f"{count} cells"
