# SPDX-License-Identifier: Apache-2.0
"""What a file says about a skin, unjudged: the common form of every format that is read."""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]


@dataclass(frozen=True)
class Defect:
    """Something wrong in a file.

    kind: one of the kinds listed in docs/layout.md; cell: where in the file; value: what stands there; why: the rule.
    """

    kind: str
    cell: str
    value: str
    why: str


@dataclass
class RawCell:
    """A cell or taxel as its file gives it; metres, link frame.

    where: what a person looks for in the file ("cell 5", "row 27"). id: None where the format has none.
    rotation: (3, 3) link_from_cell, or None where only the normal is given.
    neighbours: for ports 1 to 4 the neighbour's id (0 none), empty where the format has none.
    neighbour_ports: the neighbour's port for each, 0 where the format does not say.
    """

    where: str
    id: int | None
    group: int
    patch: int
    link: str
    position: Array
    normal: Array
    rotation: Array | None = None
    neighbours: tuple[int, ...] = ()
    neighbour_ports: tuple[int, ...] = (0, 0, 0, 0)


@dataclass
class RawLayout:
    """The cells of one file and the defects met while reading it; `Layout.load` gives a skin to run with.

    format: its name; robot: its name if the file says so; empty: slots without a cell; measured: poses come from
    reconstruction, so that a hinge gap is an error and not a choice.
    root_of_patch: id of each patch's root cell.
    """

    file: str
    format: str
    robot: str | None = None
    urdf: str | None = None
    """Of the robot, where the file names one that is there."""
    cells: list[RawCell] = field(default_factory=list)
    defects: list[Defect] = field(default_factory=list)
    empty: int = 0
    measured: bool = False
    root_of_patch: dict[int, int] = field(default_factory=dict)

    def __repr__(self) -> str:
        return f"<RawLayout of {self.robot}: {len(self.cells)} cells, {len(self.defects)} defects from {self.file}>"

    def positions(self) -> Array:
        """(N, 3) metres."""
        return np.array([cell.position for cell in self.cells]).reshape(-1, 3)

    def normals(self) -> Array:
        """(N, 3) as the file gives them, not normalised."""
        return np.array([cell.normal for cell in self.cells]).reshape(-1, 3)
