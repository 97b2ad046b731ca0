# SPDX-License-Identifier: Apache-2.0
"""Which cell is wired to which in a skin, and which cells have a cable: all that a network's limits depend on."""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import cached_property
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray
from scipy.sparse import csr_matrix
from scipy.sparse.csgraph import connected_components

from robotskin import firmware
from robotskin.layout.errors import LayoutError

if TYPE_CHECKING:
    from robotskin.layout.layout import Layout
    from robotskin.simulator import UnitDescription

Integers = NDArray[np.int64]


@dataclass(frozen=True)
class CableEnd:
    """One cable of a section unit. group: its group; unit: within the group; port: of the unit, from 1."""

    group: int
    unit: int
    port: int
    cell: int
    cell_port: int

    def __str__(self) -> str:
        unit = f".{self.unit}" if self.unit else ""
        return f"section unit {self.group}{unit} port {self.port}"

    @property
    def label(self) -> str:
        """The same where there is little room: section unit, then its unit if there are several, and port."""
        unit = f".{self.unit}" if self.unit else ""
        return f"{self.group}{unit}:{self.port}"


@dataclass(frozen=True, eq=False)
class CellNetwork:
    """N cells, their links and K cables.

    neighbours: (N, 4, 2) as in `Layout`: for own port p at row p - 1 the neighbour's index or -1, and its port 1 to 4.
    id: (N,) uint16, kept in the cells' flash; 0 where the network shall name the cell.
    group: (N,) the group that each cell's id belongs to.
    patch: (N,) index of the patch; a link between two patches is a bridge.
    link: (N,) which rigid body a cell sits on; position_m: (N, 3) in that body's frame.
    patch_names: of the patches, for people.
    """

    name: str
    neighbours: NDArray[np.int32]
    cables: tuple[CableEnd, ...]
    id: NDArray[np.uint16]
    group: NDArray[np.uint16]
    patch: NDArray[np.int32]
    link: NDArray[np.int32]
    position_m: NDArray[np.float64]
    patch_names: tuple[str, ...] = ()

    def __len__(self) -> int:
        return len(self.neighbours)

    @cached_property
    def links(self) -> Integers:
        """(L, 4) cell, port, cell, port (ports 1 to 4); each once, the smaller cell first. One-sided ones are none."""
        cell, port = np.nonzero(self.neighbours[:, :, 0] >= 0)
        other = self.neighbours[cell, port, 0].astype(np.int64)
        other_port = self.neighbours[cell, port, 1].astype(np.int64)
        back = self.neighbours[other, other_port - 1]
        mutual = (back[:, 0] == cell) & (back[:, 1] == port + 1)
        once = mutual & ((cell < other) | ((cell == other) & (port + 1 < other_port)))
        return np.stack([cell, port + 1, other, other_port], axis=1)[once].astype(np.int64)

    @cached_property
    def roots(self) -> Integers:
        """(K,) the cell of each cable."""
        return np.array([cable.cell for cable in self.cables], dtype=np.int64)

    @cached_property
    def part(self) -> Integers:
        """(N,) which connected part of the skin each cell belongs to, from 0."""
        first, second = self.links[:, 0], self.links[:, 2]
        graph = csr_matrix((np.ones(len(first), dtype=np.int8), (first, second)), shape=(len(self), len(self)))
        return connected_components(graph, directed=False)[1].astype(np.int64)

    @cached_property
    def free_ports(self) -> NDArray[np.bool_]:
        """(N, 4) whether a cell's port has neither a neighbour nor a cable."""
        free = np.asarray(self.neighbours[:, :, 0] < 0)
        for cable in self.cables:
            free[cable.cell, cable.cell_port - 1] = False
        return free

    def unit_descriptions(self) -> list[UnitDescription]:
        """The section units as the simulated network takes them."""
        from robotskin.simulator import UnitDescription

        units: dict[tuple[int, int], dict[int, tuple[int, int]]] = {}
        for cable in self.cables:
            units.setdefault((cable.group, cable.unit), {})[cable.port] = (cable.cell, cable.cell_port)
        return [
            UnitDescription(group=group, unit=unit, ports=[ports.get(p, (-1, 0)) for p in range(1, max(ports) + 1)])
            for (group, unit), ports in sorted(units.items())
        ]

    @classmethod
    def of_layout(cls, layout: Layout) -> CellNetwork:
        """The network of a layout, cables as it plans them; a port beyond 15 belongs to a further unit of its group."""
        cables = []
        for place in layout.section_unit_ports:
            unit, port = divmod(place.port - 1, firmware.SECTION_UNIT_PORTS_MAX)
            cables.append(CableEnd(place.group, unit, port + 1, place.cell, place.cell_port))
        return cls(
            layout.robot,
            layout.neighbours,
            tuple(cables),
            layout.id,
            layout.group,
            layout.patch,
            layout.link,
            np.asarray(layout.link_from_cell[:, :3, 3]),
            tuple(patch.name for patch in layout.patches),
        )

    def with_cables(self, ends: list[tuple[int, int]], units: int = 1, group: int = 1) -> CellNetwork:
        """The same cells with other cables.

        ends: (cell, cell port) of each cable; units: section units of one group to which they are dealt in turn.

        Raises:
            LayoutError: a port that has a neighbour, or more than 15 cables for a section unit.
        """
        free = self.neighbours[:, :, 0] < 0
        cables = []
        for number, (cell, port) in enumerate(ends):
            if not free[cell, port - 1]:
                raise LayoutError(f"cable at cell {cell} port {port}: a neighbour or another cable is there")
            free[cell, port - 1] = False
            cables.append(CableEnd(group, number % units, number // units + 1, cell, port))
        most = firmware.SECTION_UNIT_PORTS_MAX
        if len(ends) > units * most:
            raise LayoutError(f"{len(ends)} cables on {units} section units: each takes {most}")
        groups = np.full(len(self), group, dtype=np.uint16)
        return replace(self, cables=tuple(cables), group=groups)

    def with_cable(self, cell: int, cell_port: int) -> CellNetwork:
        """The same with one more cable, at a free port."""
        new = CableEnd(int(self.group[cell]), 0, 0, cell, cell_port)
        return replace(self, cables=(*self.cables, new))

    def with_bridge(self, cell: int, cell_port: int, other: int, other_port: int) -> CellNetwork:
        """The same with one more link, between two free ports."""
        neighbours = self.neighbours.copy()
        neighbours[cell, cell_port - 1] = other, other_port
        neighbours[other, other_port - 1] = cell, cell_port
        return replace(self, neighbours=neighbours)

    def patch_name(self, cell: int) -> str:
        """Of a cell's patch."""
        number = int(self.patch[cell])
        return self.patch_names[number] if 0 <= number < len(self.patch_names) else f"patch {number}"

    def cell_name(self, cell: int) -> str:
        """Of a cell: the index by which faults and pages name it, and the id, if any, by which the network does."""
        return f"cell {cell} (id {self.id[cell]})" if self.id[cell] else f"cell {cell}"
