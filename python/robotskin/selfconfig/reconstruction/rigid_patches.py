# SPDX-License-Identifier: Apache-2.0
"""The shapes of all patches, as the reconstruction left them: what the kinematics builds on."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray
from scipy.sparse import coo_array
from scipy.sparse.csgraph import connected_components

from robotskin.selfconfig.reconstruction.reconstruction import Reconstruction
from robotskin.selfconfig.topology.topology import Topology

Array = NDArray[np.float64]


@dataclass(frozen=True, eq=False)
class RigidPatches:
    """N cells on P patches; a lone cell is a patch of one.

    patch: (N,) number of each cell's patch, 0 to P − 1. root_from_cell: (N, 4, 4) metres, in the frame of the patch.
    rotation_deviation_rad: (N,) how far a cell's rotation may be from it, along one axis.
    position_covariance: (N, 3, 3) m², patch frame.
    hinges: (E, 4) cell, port index, neighbour, port index, between cells that are patches of their own.
    """

    patch: NDArray[np.int64]
    root_from_cell: Array
    rotation_deviation_rad: Array
    position_covariance: Array
    hinges: NDArray[np.int64] = field(default_factory=lambda: np.zeros((0, 4), dtype=np.int64))

    def __post_init__(self) -> None:
        count = len(self.patch)
        if self.root_from_cell.shape != (count, 4, 4) or self.rotation_deviation_rad.shape != (count,):
            raise ValueError(f"{count} cells with poses of shape {self.root_from_cell.shape}")
        if count == 0 or not np.array_equal(np.unique(self.patch), np.arange(self.patch.max() + 1)):
            raise ValueError("patches must be numbered from 0 without a gap")

    @property
    def count(self) -> int:
        """The number P of patches."""
        return int(self.patch.max()) + 1

    @classmethod
    def of(cls, topology: Topology, reconstructions: Sequence[Reconstruction]) -> RigidPatches:
        """From the reconstructions of a skin.

        A patch on a link in which gravity never turns has none (`UnobservableRotationError`). Its cells become patches
        of one, held together by their hinges; how a joint moves them can still tell its shape.

        Args:
            topology: of N cells.
            reconstructions: of its patches, one each, or fewer.

        Raises:
            ValueError: a cell lies on two.
        """
        count = len(topology.cell)
        patch = np.full(count, -1)
        pose, deviation = np.tile(np.eye(4), (count, 1, 1)), np.zeros(count)
        position = np.zeros((count, 3, 3))
        for number, one in enumerate(reconstructions):
            if (patch[one.cells] >= 0).any():
                raise ValueError(f"patch {number}: a cell lies on patch {patch[one.cells].max()} already")
            patch[one.cells], pose[one.cells] = number, one.root_from_cell
            own = np.sqrt(np.trace(one.covariance[:, :3, :3], axis1=1, axis2=2) / 3)
            # The root is exact only as the frame of the others; its own reading errs as theirs do.
            own[one.root] = np.median(np.delete(own, one.root)) if len(own) > 1 else 0.0
            deviation[one.cells] = own
            position[one.cells] = one.covariance[:, 3:, 3:]
        lone = np.flatnonzero(patch < 0)
        patch[lone] = len(reconstructions) + np.arange(len(lone))
        hinges = topology.edges[np.isin(topology.edges[:, 0], lone)]
        return cls(patch, pose, deviation, position, hinges)

    @classmethod
    def lone_cells(cls, count: int) -> RigidPatches:
        """Cells of which nothing is known: each is its own patch and frame."""
        return cls(np.arange(count), np.tile(np.eye(4), (count, 1, 1)), np.zeros(count), np.zeros((count, 3, 3)))

    def groups(self) -> NDArray[np.int64]:
        """(P,) number of the group of each patch; patches joined by hinges are one."""
        ends = self.patch[self.hinges[:, [0, 2]]]
        graph = coo_array((np.ones(len(ends)), (ends[:, 0], ends[:, 1])), shape=(self.count, self.count))
        return connected_components(graph, directed=False)[1].astype(np.int64)
