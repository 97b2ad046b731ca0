# SPDX-License-Identifier: Apache-2.0
"""Closing the loops of a patch that was reconstructed along a tree, from the rotations it stored.

A chain of poses leaves the whole error of each loop in the one edge that closes it. Here the stored rotation of every
tree edge and the hinge of every edge are weighed against each other.
"""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.typing import NDArray
from scipy.spatial.transform import Rotation

from robotskin.layout.formats import read
from robotskin.selfconfig.reconstruction.gravity_adjustment import hinge_jacobian
from robotskin.selfconfig.reconstruction.hinge import gap_vectors
from robotskin.selfconfig.topology.neighbours import NeighbourLists
from robotskin.selfconfig.topology.topology import Topology, explore

Array = NDArray[np.float64]


@dataclass(frozen=True, eq=False)
class StoredPatch:
    """A patch from a file: its topology, and root_from_cell (N, 4, 4) metres in the topology's order and root's frame.

    tree: (E,) edges whose hinge closes in the stored poses: the tree along which they were chained. The other edges
    close loops.
    """

    topology: Topology
    root_from_cell: Array
    tree: NDArray[np.bool_]

    def loop_edges(self) -> NDArray[np.int64]:
        """(L,) numbers of the edges that close a loop."""
        return np.flatnonzero(~self.tree)

    def edge_name(self, edge: int) -> str:
        """Cells and ports of an edge, as "11.2-6.3"."""
        first, port, second, other_port = self.topology.edges[edge]
        return f"{self.topology.cell[first]}.{port + 1}-{self.topology.cell[second]}.{other_port + 1}"


def read_stored_patch(path: str | Path, closed_m: float = 2e-5) -> StoredPatch:
    """Read the patch of a TUM file (JSON or XML).

    Args:
        path: of the file.
        closed_m: gap up to which a hinge counts as chained; files store poses to micrometres.

    Raises:
        ValueError: no cell with a full pose and neighbours.
    """
    skin = read(path)
    cells = [cell for cell in skin.cells if cell.rotation is not None and cell.id is not None and cell.neighbours]
    if not cells:
        raise ValueError(f"{path}: no cell with a rotation and neighbours; this is {skin.format}")
    lists = NeighbourLists(
        [int(cell.id or 0) for cell in cells],
        [cell.neighbours for cell in cells],
        [cell.neighbour_ports for cell in cells],
    )
    topology = explore(lists)
    row = {int(key): number for number, key in enumerate(topology.cell)}
    pose = np.tile(np.eye(4), (len(row), 1, 1))
    for cell in cells:
        pose[row[int(cell.id or 0)], :3, :3] = cell.rotation
        pose[row[int(cell.id or 0)], :3, 3] = cell.position
    root = np.array([topology.root[patch] for patch in topology.patch])
    root_from_cell = np.linalg.inv(pose[root]) @ pose
    tree = np.linalg.norm(gap_vectors(root_from_cell, topology.edges), axis=1) <= closed_m
    return StoredPatch(topology, root_from_cell, tree)


def close_loops(
    stored: StoredPatch,
    rotation_deviation_rad: float = 0.01,
    hinge_m: float = 2e-4,
    without_edge: int | None = None,
    passes: int = 50,
) -> Array:
    """Poses that keep the stored rotation of every tree edge and close every hinge as far as the two agree.

    Minimises Σ |log(R_eᵀ R_iᵀ R_j)|²/σ_r² over tree edges + Σ |p_i + R_i a_p − p_j − R_j a_q|²/σ_h² over all edges;
    only the ratio of the two deviations matters. A published rotation comes from two poses of 16 samples, so σ_r is
    that of a two-pose Procrustes.

    Args:
        stored: the patch.
        rotation_deviation_rad: trust in a stored rotation across one edge, standard deviation an axis.
        hinge_m: tolerance of a hinge, standard deviation an axis.
        without_edge: number of a loop edge that is not to be used, so that its gap is predicted.
        passes: Gauss-Newton steps at most.

    Returns:
        (N, 4, 4) root_from_cell, metres.

    Raises:
        ValueError: no such loop edge, or a deviation that is not positive.
    """
    if not (rotation_deviation_rad > 0 and hinge_m > 0):
        raise ValueError(f"deviations {rotation_deviation_rad} rad, {hinge_m} m: must be positive")
    topology = stored.topology
    used = np.ones(len(topology.edges), dtype=bool)
    if without_edge is not None:
        if without_edge not in stored.loop_edges():
            raise ValueError(f"without_edge {without_edge}: must be one of {stored.loop_edges().tolist()}")
        used[without_edge] = False
    edges, tree_edges = topology.edges[used], topology.edges[stored.tree]
    pose = stored.root_from_cell.copy()
    first, second = tree_edges[:, 0], tree_edges[:, 2]
    across = np.swapaxes(pose[first, :3, :3], 1, 2) @ pose[second, :3, :3]
    count = len(pose)
    free = np.setdiff1d(np.arange(count), topology.root)
    for _ in range(passes):
        turn = np.swapaxes(pose[first, :3, :3], 1, 2) @ pose[second, :3, :3]
        bend = Rotation.from_matrix(np.swapaxes(across, 1, 2) @ turn).as_rotvec().reshape(-1, 3)
        keep = np.zeros((len(tree_edges), 3, count, 6))
        at = np.arange(len(tree_edges))
        keep[at, :, first, :3] = -np.swapaxes(turn, 1, 2)
        keep[at, :, second, :3] = np.eye(3)
        meet = np.zeros((len(edges), 3, count, 6))
        both = hinge_jacobian(pose, edges)
        at = np.arange(len(edges))
        meet[at, :, edges[:, 0]] = both[:, :, :6]
        meet[at, :, edges[:, 2]] = both[:, :, 6:]
        jacobian = np.concatenate(
            [
                keep[:, :, free].reshape(-1, 6 * len(free)) / rotation_deviation_rad,
                meet[:, :, free].reshape(-1, 6 * len(free)) / hinge_m,
            ]
        )
        residual = np.concatenate([bend.ravel() / rotation_deviation_rad, gap_vectors(pose, edges).ravel() / hinge_m])
        step = np.linalg.lstsq(jacobian, -residual, rcond=None)[0].reshape(-1, 6)
        pose[free, :3, :3] = pose[free, :3, :3] @ Rotation.from_rotvec(step[:, :3]).as_matrix()
        pose[free, :3, 3] += step[:, 3:]
        if np.abs(step).max(initial=0.0) < 1e-9:
            break
    return pose


def gap_lengths(root_from_cell: Array, edges: NDArray[np.integer]) -> Array:
    """(E,) metres, distance between the two hinge points of each edge."""
    return np.linalg.norm(gap_vectors(root_from_cell, edges), axis=1)


def rotation_changes(before: Array, after: Array) -> Array:
    """(N,) rad, angle by which each cell was turned."""
    return Rotation.from_matrix(np.swapaxes(before[:, :3, :3], 1, 2) @ after[:, :3, :3]).magnitude()
