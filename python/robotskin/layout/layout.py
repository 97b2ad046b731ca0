# SPDX-License-Identifier: Apache-2.0
"""A skin layout: which cell sits where on which link, which its neighbours are and where the cables plug in."""

from __future__ import annotations

from dataclasses import dataclass, field
from pathlib import Path
from typing import TYPE_CHECKING, Protocol

import numpy as np
from numpy.typing import ArrayLike, NDArray

from robotskin import firmware
from robotskin.layout.cell import PORTS, hinge_gaps
from robotskin.layout.errors import LayoutError

if TYPE_CHECKING:
    from robotskin.skin import SkinModel


@dataclass(frozen=True)
class Patch:
    """Cells joined by hinges, laid on one link. root: index of the cell whose place anchors the others."""

    name: str
    link: str
    root: int


@dataclass(frozen=True)
class SectionUnitPort:
    """Where a cable from a section unit plugs in.

    group: of the unit; port: of the section unit, from 1; cell: index; cell_port: 1 to 4, free of neighbours.
    """

    group: int
    port: int
    cell: int
    cell_port: int


@dataclass(frozen=True)
class Stud:
    """An anchor on a link's mesh to which the elastics of a patch are tied (paper, II-E1).

    patch: index; link: name; point_m, normal: (3,) in the link frame.
    """

    patch: int
    link: str
    point_m: tuple[float, float, float]
    normal: tuple[float, float, float]


@dataclass(frozen=True)
class Cable:
    """The cable of one section-unit port, from its cell to the section unit (paper, II-E2).

    route: (link, point in that link's frame, metres), from the cell to the section unit; the way on a link is fixed,
    the way across a joint is a straight piece between the two points beside it.
    length_min_m, length_max_m: over the joint range; length_neutral_m: in the neutral posture.
    worst_stretch: length_max / length_neutral - 1, what a reel must give out.
    """

    group: int
    port: int
    route: tuple[tuple[str, tuple[float, float, float]], ...]
    length_neutral_m: float
    length_min_m: float
    length_max_m: float
    worst_stretch: float


class ForceCalibration(Protocol):
    """What force sensors show, as what they felt."""

    def offset_and_matrix(self) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
        """(N, 3) newton and (N, 3, 3): felt = matrix (shown - offset)."""

    def to_text(self) -> str:
        """As a file holds it."""


@dataclass(frozen=True, eq=False)
class Layout:
    """A skin on a robot; struct of arrays, cell axis first, N cells. Arrays are read-only.

    robot: its name; links: names that `link` indexes.
    id: (N,) uint16, 1 to 16382, unique within a section-unit group; group: (N,) uint16, the group.
    link: (N,) index into links; link_from_cell: (N, 4, 4), metres, z the outward normal, origin on the outer face.
    neighbours: (N, 4, 2): for own port p at row p - 1, the neighbour's index or -1 and its port 1 to 4 (0 for none).
    patch: (N,) index into patches.
    calibration: what is known of its force sensors (`robotskin.calibration`); no part of the layout's file. None:
    forces are taken as they are shown.
    """

    robot: str
    links: tuple[str, ...]
    id: NDArray[np.uint16]
    group: NDArray[np.uint16]
    link: NDArray[np.int32]
    link_from_cell: NDArray[np.float64]
    neighbours: NDArray[np.int32]
    patch: NDArray[np.int32]
    patches: tuple[Patch, ...] = ()
    section_unit_ports: tuple[SectionUnitPort, ...] = ()
    cables: tuple[Cable, ...] = ()
    studs: tuple[Stud, ...] = ()
    source: str = field(default="", compare=False)
    urdf: str = field(default="", compare=False)
    """Path of the robot's URDF; empty for a robot that is known by its name."""
    calibration: ForceCalibration | None = field(default=None, compare=False, repr=False)

    def __repr__(self) -> str:
        links = ", ".join(self.links)
        where = f" from {self.source}" if self.source else ""
        return f"<Layout of {self.robot}: {len(self)} cells in {len(self.patches)} patches on {links}{where}>"

    def __post_init__(self) -> None:
        count = len(self.id)
        shapes = {
            "id": (np.uint16, (count,)),
            "group": (np.uint16, (count,)),
            "link": (np.int32, (count,)),
            "link_from_cell": (np.float64, (count, 4, 4)),
            "neighbours": (np.int32, (count, PORTS, 2)),
            "patch": (np.int32, (count,)),
        }
        for name, (kind, shape) in shapes.items():
            array = np.array(getattr(self, name), dtype=kind, order="C")
            if array.shape != shape:
                raise LayoutError(f"{name}: shape {array.shape}, expected {shape}")
            array.setflags(write=False)
            object.__setattr__(self, name, array)
        self._require("id", (self.id < firmware.ID_FIRST) | (self.id > firmware.ID_LAST), self.id, "1 to 16382")
        self._require(
            "link", (self.link < 0) | (self.link >= len(self.links)), self.link, f"0 to {len(self.links) - 1}"
        )
        neighbour, port = self.neighbours[:, :, 0], self.neighbours[:, :, 1]
        self._require("neighbours", ((neighbour < -1) | (neighbour >= count)).any(1), neighbour, f"-1 to {count - 1}")
        self._require("neighbours' ports", ((neighbour >= 0) & ((port < 1) | (port > PORTS))).any(1), port, "1 to 4")
        self._require("link_from_cell", ~np.isfinite(self.link_from_cell).all((1, 2)), self.link_from_cell, "finite")
        keys = self.keys
        _, first, times = np.unique(keys, return_index=True, return_counts=True)
        repeated = np.zeros(count, dtype=bool)
        repeated[first[times > 1]] = True
        self._require("id", repeated, self.id, "once in its section-unit group")
        for place in self.section_unit_ports:
            if not (0 <= place.cell < count and 1 <= place.cell_port <= PORTS):
                raise LayoutError(f"section_unit_ports: {place}: cell must be 0 to {count - 1}, cell_port 1 to 4")
            if neighbour[place.cell, place.cell_port - 1] >= 0:
                raise LayoutError(f"section_unit_ports: {place}: that port of the cell already has a neighbour")
        for patch in self.patches:
            if not 0 <= patch.root < count or patch.link not in self.links:
                raise LayoutError(f"patches: {patch}: root must be 0 to {count - 1}, link one of {self.links}")
        self._require(
            "patch", (self.patch < -1) | (self.patch >= len(self.patches)), self.patch, "index of a patch or -1"
        )

    @staticmethod
    def _require(name: str, breaks: ArrayLike, values: NDArray, valid: str) -> None:
        wrong = np.asarray(breaks, dtype=bool)
        if wrong.any():
            cell = int(np.argmax(wrong))
            raise LayoutError(f"{name} of cell {cell}: {values[cell].tolist()}: must be {valid}")

    def __len__(self) -> int:
        return len(self.id)

    def edges(self) -> NDArray[np.int64]:
        """(E, 4) rows of cell, port index, neighbour, its port index; each mutual edge once, one-way edges too."""
        cell, port = np.nonzero(self.neighbours[:, :, 0] >= 0)
        other, other_port = self.neighbours[cell, port, 0], self.neighbours[cell, port, 1] - 1
        back = (self.neighbours[other, other_port, 0] == cell) & (self.neighbours[other, other_port, 1] == port + 1)
        once = ~back | (cell < other) | ((cell == other) & (port <= other_port))
        return np.stack([cell, port, other, other_port], axis=1)[once].astype(np.int64)

    def hinge_edges(self) -> NDArray[np.int64]:
        """(E, 4) the edges inside patches: those a flexible hinge makes. Edges between patches are jumper cables."""
        edges = self.edges()
        return edges[
            (self.patch[edges[:, 0]] == self.patch[edges[:, 2]]) & (self.link[edges[:, 0]] == self.link[edges[:, 2]])
        ]

    def gaps(self) -> NDArray[np.float64]:
        """(E,) metres, hinge gap of each of `hinge_edges()`."""
        return hinge_gaps(self.link_from_cell, *self.hinge_edges().T)

    def cells_on(self, link: str) -> NDArray[np.int64]:
        """(C,) indices of the cells on a link. Raises LayoutError for a link without cells."""
        if link not in self.links:
            raise LayoutError(f"no link {link!r} in this layout; it has {', '.join(self.links)}")
        return np.flatnonzero(self.link == self.links.index(link))

    @property
    def keys(self) -> NDArray[np.int64]:
        """(N) of each cell, by which samples name it: section-unit group << 16 | id."""
        return self.group.astype(np.int64) << 16 | self.id

    def cells_of(self, keys: ArrayLike) -> NDArray[np.int64]:
        """(K,) indices of the cells with these `keys` (K,); -1 for those of no cell."""
        own, asked = self.keys, np.asarray(keys, dtype=np.int64)
        order = np.argsort(own)
        at = order[np.clip(np.searchsorted(own, asked, sorter=order), 0, len(own) - 1)]
        return np.where(own[at] == asked, at, -1)

    def skin_model(self) -> SkinModel:
        """The constant model that driver and control take, from the same arrays."""
        from robotskin.skin import SkinModel

        model = SkinModel(
            link_names=list(self.links),
            key=self.keys.astype(np.uint32),
            link=self.link,
            link_from_cell=self.link_from_cell,
            neighbours=self.neighbours,
            patch=self.patch,
        )
        if self.calibration is not None:
            model.set_force_calibration(*self.calibration.offset_and_matrix())
        return model

    def save(self, path: str | Path) -> None:
        """Write the layout as JSON (docs/layout.md), gzipped if the name ends in .gz; never leaves half a file."""
        from robotskin.layout.json_file import save

        save(self, Path(path))

    @classmethod
    def load(cls, path: str | Path) -> Layout:
        """Read a layout written by `save` or by hand.

        Raises:
            LayoutFileError: naming file, field and value of what is wrong.
        """
        from robotskin.layout.json_file import load

        return load(Path(path))
