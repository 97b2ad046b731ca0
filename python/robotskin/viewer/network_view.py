# SPDX-License-Identifier: Apache-2.0
"""What the page sees of a living cell network, and what a person may do to it."""

from dataclasses import dataclass
from typing import Protocol

import numpy as np
from numpy.typing import NDArray

from robotskin.viewer.session_view import Floats, Integers

Flags = NDArray[np.bool_]

NO_PATH = -1
"""In `NetworkReading.cable`: the cell has no way to a section unit."""


@dataclass(frozen=True)
class NetworkReading:
    """One moment of N cells with four ports each and P cables: nothing in it changes after it was taken."""

    time_s: float
    parent_port: Integers
    """(N,) the port to the cell's parent, 1 to 4; 0 while it has none."""
    cable: Integers
    """(N,) index in `Layout.section_unit_ports` of the cable at the end of the cell's path, or `NO_PATH`."""
    hops: Integers
    """(N,) from the cell to its section unit; 0 without a path."""
    alive: Flags
    """(N,) has power and runs."""
    cut: Flags
    """(N, 4) the wire at this port is cut."""
    damaged: Integers
    """(N, 4) frames that arrived damaged at this port since the start."""
    moved_s: Floats
    """(N,) when the cell last changed its parent; -inf for never."""
    damaged_s: Floats
    """(N, 4) when a damaged frame last arrived at this port; -inf for never."""
    stranded: int = 0
    """Cells that run or start and could be reached over wires that work, but have no path yet."""
    news: str = ""
    """What happened last, in a sentence."""

    def load(self, cables: int) -> Integers:
        """(cables,) cells that report through each cable."""
        return np.bincount(self.cable[self.cable >= 0], minlength=cables)


PACES = {"real time": 1.0, "10 times slower": 0.1, "100 times slower": 0.01, "1000 times slower": 0.001, "paused": 0.0}
"""How fast the time of a simulated network runs beside the wall clock's, by what a person reads."""


class NetworkView(Protocol):
    """A living network. Every call may come from any thread and returns at once."""

    @property
    def paced(self) -> bool:
        """Whether `set_pace` is obeyed: not where the network runs in the time of something else."""

    def reading(self) -> NetworkReading:
        """The latest moment."""

    def toggle_link(self, cell: int, port: int) -> None:
        """Cut the wire at a cell's port, 1 to 4, or mend it."""

    def disturb_link(self, cell: int, port: int) -> None:
        """Let the wire at a cell's port, 1 to 4, damage frames for a while."""

    def toggle_cell(self, cell: int) -> None:
        """Kill a cell, or start a dead one."""

    def mend(self) -> None:
        """Mend all wires and start all cells."""

    def set_pace(self, pace: float) -> None:
        """Seconds of the network for one of the wall clock, 0 to stand still."""
