# SPDX-License-Identifier: Apache-2.0
"""The flexible joint between two cells: both rigid cells share one point, and turn about it freely (facts, 1g)."""

from __future__ import annotations

from collections.abc import Iterable

import numpy as np
from numpy.typing import NDArray

from robotskin.layout.cell import PORT_POINTS_M


def gap_vectors(patch_from_cell: NDArray[np.float64], edges: NDArray[np.integer]) -> NDArray[np.float64]:
    """Hinge point of the first cell less that of the second; zero where t = a_p - R a_q holds.

    Args:
        patch_from_cell: (N, 4, 4) metres.
        edges: (E, 4) cell, port index, neighbour, port index.

    Returns:
        (E, 3) metres, patch frame.
    """
    return hinge_points(patch_from_cell, edges[:, 0], edges[:, 1]) - hinge_points(
        patch_from_cell, edges[:, 2], edges[:, 3]
    )


def hinge_points(
    patch_from_cell: NDArray[np.float64], cell: NDArray[np.integer], port: NDArray[np.integer]
) -> NDArray[np.float64]:
    """(E, 3) metres, the points of ports (index 0 to 3) of cells in the patch frame."""
    arm = np.einsum("eij,ej->ei", patch_from_cell[cell, :3, :3], PORT_POINTS_M[port])
    return patch_from_cell[cell, :3, 3] + arm


def flat_rotations(edges: NDArray[np.integer]) -> NDArray[np.float64]:
    """(E, 3, 3) rotation cell_from_neighbour of an unbent hinge: the two ports look at each other in one plane."""
    direction = np.arctan2(PORT_POINTS_M[:, 1], PORT_POINTS_M[:, 0])
    yaw = direction[edges[:, 1]] - direction[edges[:, 3]] + np.pi
    rotation = np.tile(np.eye(3), (len(edges), 1, 1))
    rotation[:, 0, 0] = rotation[:, 1, 1] = np.cos(yaw)
    rotation[:, 1, 0] = np.sin(yaw)
    rotation[:, 0, 1] = -np.sin(yaw)
    return rotation


def chain(
    cell_from_parent: NDArray[np.float64],
    parent: NDArray[np.integer],
    order: Iterable[int],
    edges: NDArray[np.integer],
    parent_edge: NDArray[np.integer],
) -> NDArray[np.float64]:
    """Poses along the paths to the root, from the rotation across each edge of a path [Cheng19 eq. 1, 3].

    Args:
        cell_from_parent: (N, 3, 3) rotation of each cell's parent into the cell; ignored at roots.
        parent: (N,) the cell's parent, -1 at roots.
        order: cells, each after its parent.
        edges: (E, 4) cell, port index, neighbour, port index.
        parent_edge: (N,) edge between cell and parent, -1 at roots.

    Returns:
        (N, 4, 4) root_from_cell, metres.
    """
    pose = np.tile(np.eye(4), (len(parent), 1, 1))
    for cell in order:
        above = parent[cell]
        if above < 0:
            continue
        edge = edges[parent_edge[cell]]
        port, port_above = (edge[1], edge[3]) if edge[0] == cell else (edge[3], edge[1])
        # [Cheng19 eq. 3]
        pose[cell, :3, :3] = pose[above, :3, :3] @ cell_from_parent[cell].T
        meeting = pose[above, :3, 3] + pose[above, :3, :3] @ PORT_POINTS_M[port_above]
        # [Cheng19 eq. 1]: its translation, by the shape of the cells
        pose[cell, :3, 3] = meeting - pose[cell, :3, :3] @ PORT_POINTS_M[port]
    return pose
