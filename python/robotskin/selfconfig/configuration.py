# SPDX-License-Identifier: Apache-2.0
"""What a skin found out about itself: its patches, each with shape and place, and the layout made of them.

Nothing is guessed: a patch whose shape or place the motion leaves open is not placed, and says why.
"""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from robotskin.errors import RobotskinError
from robotskin.layout import Layout, Patch, SectionUnitPort
from robotskin.selfconfig.common.rotations import cross_matrix
from robotskin.selfconfig.kinematics.activity import KinematicTree
from robotskin.selfconfig.kinematics.estimate import KinematicEstimate
from robotskin.selfconfig.localisation.localisation import Localisation
from robotskin.selfconfig.reconstruction.reconstruction import Reconstruction
from robotskin.selfconfig.topology.topology import Topology

Array = NDArray[np.float64]


class ConfigurationError(RobotskinError):
    """A configuration of which nothing can be used."""


@dataclass(frozen=True, eq=False)
class ConfiguredPatch:
    """What is known of one patch.

    cells: (n,) rows of the topology; reconstruction: its shape; localisation: its place; None where the data cannot
    tell, and `problem` says why. by: what told them, "motion" or "pictures".
    """

    cells: NDArray[np.int64]
    reconstruction: Reconstruction | None = None
    localisation: Localisation | None = None
    problem: str = ""
    by: str = "motion"

    @property
    def placed(self) -> bool:
        """Whether shape and place are known in every direction."""
        return self.reconstruction is not None and self.localisation is not None and not self.localisation.open

    def link_from_cell(self) -> Array:
        """(n, 4, 4) metres, of a placed patch. Raises ConfigurationError for another."""
        if self.reconstruction is None or self.localisation is None:
            raise ConfigurationError(f"patch of {len(self.cells)} cells: {self.problem}")
        return self.localisation.link_from_patch @ self.reconstruction.root_from_cell

    def covariance(self) -> Array:
        """(n, 6, 6) of an error (w, d) of each cell of a placed patch: true rotation = R exp(w), true place = p + d.

        w counts in the cell's frame, rad, and d in the link's, m: the patch's own error as every cell has it, and what
        the cell errs by beside its patch. Raises ConfigurationError for a patch that is not placed.
        """
        if self.reconstruction is None or self.localisation is None:
            raise ConfigurationError(f"patch of {len(self.cells)} cells: {self.problem}")
        shape, link_from_root = self.reconstruction.root_from_cell, self.localisation.link_from_patch[:3, :3]
        carried = np.zeros((len(shape), 6, 6))
        carried[:, :3, :3] = np.swapaxes(shape[:, :3, :3], 1, 2)
        carried[:, 3:, :3] = -link_from_root @ cross_matrix(shape[:, :3, 3])
        carried[:, 3:, 3:] = np.eye(3)
        beside = np.eye(6)
        beside[3:, 3:] = link_from_root
        whole = carried @ self.localisation.patch_covariance @ np.swapaxes(carried, 1, 2)
        return np.asarray(whole + beside @ self.reconstruction.inner_covariance @ beside.T, dtype=np.float64)


@dataclass(frozen=True, eq=False)
class Configuration:
    """What the skin found out about itself; N cells in the order of `topology.cell`.

    activity: (n, N) which joint moves which cell; tree: of the rigid segments, None if the matrix makes none.
    swung: (n,) whether a joint swung at all; the rows of others are empty, not measured.
    kinematics: from the skin alone, None where it was not asked for or, as `kinematics_problem` says, not found.
    seconds: time that each step computed.
    """

    robot: str
    topology: Topology
    activity: NDArray[np.bool_]
    swung: NDArray[np.bool_]
    tree: KinematicTree | None
    patches: tuple[ConfiguredPatch, ...]
    unit_ports: NDArray[np.int64]
    kinematics: KinematicEstimate | None = None
    kinematics_problem: str = ""
    seconds: dict[str, float] = field(default_factory=dict)

    def placed(self) -> NDArray[np.bool_]:
        """(N,) whether a cell's place is known."""
        mask = np.zeros(len(self.topology.cell), dtype=bool)
        for patch in self.patches:
            mask[patch.cells] = patch.placed
        return mask

    def layout(self) -> Layout:
        """The layout of all placed cells, in the order of their keys.

        Raises:
            ConfigurationError: no cell is placed.
        """
        return layout_of(self)


def layout_of(configuration: Configuration) -> Layout:
    """See `Configuration.layout`."""
    topology = configuration.topology
    placed = [patch for patch in configuration.patches if patch.placed]
    if not placed:
        reasons = "; ".join(patch.problem for patch in configuration.patches if patch.problem)
        raise ConfigurationError(f"no patch of {len(configuration.patches)} is placed: {reasons[:500]}")
    rows = np.sort(np.concatenate([patch.cells for patch in placed]))
    new = np.full(len(topology.cell), -1)
    new[rows] = np.arange(len(rows))
    links = tuple(dict.fromkeys(patch.localisation.link for patch in placed if patch.localisation))
    pose, link = np.tile(np.eye(4), (len(rows), 1, 1)), np.zeros(len(rows), dtype=np.int32)
    patch_number = np.zeros(len(rows), dtype=np.int32)
    records: list[Patch] = []
    for number, patch in enumerate(placed):
        assert patch.localisation is not None
        assert patch.reconstruction is not None
        here, name = new[patch.cells], patch.localisation.link
        pose[here], link[here], patch_number[here] = patch.link_from_cell(), links.index(name), number
        root = int(here[patch.reconstruction.root])
        records.append(Patch(f"{name}_{sum(one.link == name for one in records) + 1}", name, root))
    neighbours = np.full((len(rows), 4, 2), (-1, 0), dtype=np.int32)
    for cell, port, other, other_port in topology.edges:
        if new[cell] >= 0 and new[other] >= 0:
            neighbours[new[cell], port] = new[other], other_port + 1
            neighbours[new[other], other_port] = new[cell], port + 1
    ports = [
        SectionUnitPort(int(group), int(port), int(new[cell]), int(cell_port))
        for group, port, cell, cell_port in configuration.unit_ports
        if new[cell] >= 0 and neighbours[new[cell], cell_port - 1, 0] < 0
    ]
    key = topology.cell[rows]
    return Layout(
        configuration.robot,
        links,
        (key & 0xFFFF).astype(np.uint16),
        (key >> 16).astype(np.uint16),
        link,
        pose,
        neighbours,
        patch_number,
        tuple(records),
        tuple(ports),
        source="self-configuration",
    )
