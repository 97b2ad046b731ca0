# SPDX-License-Identifier: Apache-2.0
"""The rigid body of a cell: its port points and its hexagonal prism, in the cell frame.

Every dimension comes from the firmware's geometry header; here it only becomes arrays.
"""

import numpy as np
from numpy.typing import NDArray

from robotskin import firmware

PORTS = 4
CELLS_PER_PORT: int = firmware.CELLS_PER_PORT
HEXAGON_SIDE_M: float = firmware.HEXAGON_SIDE_M
CELL_THICKNESS_M: float = firmware.CELL_THICKNESS_M
HINGE_REACH_M: float = firmware.HINGE_REACH_M
LATTICE_PITCH_M: float = firmware.LATTICE_PITCH_M

PORT_POINTS_M: NDArray[np.float64] = np.zeros((PORTS, 3))
"""(4, 3) metres, the hinge point of port p at row p - 1."""
PORT_POINTS_M[:, :2] = np.asarray(firmware.PORT_POINTS_M)[:, :2]

FLAT_PARTNER = np.array([3, 2, 1, 0])
"""(4,) index of the port that faces port index p in the flat lattice (1-4 and 2-3)."""

LATTICE_CELL_AREA_M2 = float(abs(np.linalg.det(2 * PORT_POINTS_M[:2, :2])))
"""Surface that one cell of the flat lattice takes, flexible joints included."""

_ANGLES = np.arange(6) * np.pi / 3
HEXAGON_M: NDArray[np.float64] = HEXAGON_SIDE_M * np.stack([np.cos(_ANGLES), np.sin(_ANGLES)], axis=1)
"""(6, 2) corners; a corner lies on the x axis, so that flats face the six lattice neighbours at 30, 90, ... degrees."""

FLAT_NORMALS: NDArray[np.float64] = np.stack([np.cos(_ANGLES[:3] + np.pi / 6), np.sin(_ANGLES[:3] + np.pi / 6)], axis=1)
"""(3, 2) unit normals of the three pairs of flats."""


PRISM_CORNERS_M = np.concatenate(
    [np.column_stack([HEXAGON_M, np.zeros(6)]), np.column_stack([HEXAGON_M, np.full(6, -CELL_THICKNESS_M)])]
)
"""(12, 3) corners of the front face, then of the back."""
FACE_NORMALS = np.concatenate([np.column_stack([FLAT_NORMALS, np.zeros(3)]), [[0.0, 0.0, 1.0]]])
"""(4, 3) unit normals of the prism's parallel pairs of faces."""
EDGE_DIRECTIONS = np.concatenate(
    [np.column_stack([-FLAT_NORMALS[:, 1], FLAT_NORMALS[:, 0], np.zeros(3)]), [[0.0, 0.0, 1.0]]]
)
"""(4, 3) unit directions of the prism's edges."""


def prism_points(rings: int = 2) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Points that sample the back and the front face of a cell's prism.

    Args:
        rings: hexagonal rings around the centre, the last on the rim; 2 gives a point each 7 mm.

    Returns:
        back (K, 3), front (K, 3), metres, cell frame (front at z = 0, back one cell thickness below).
    """
    points = [np.zeros(2)]
    for ring in range(1, rings + 1):
        for corner in range(6):
            start, end = HEXAGON_M[corner], HEXAGON_M[(corner + 1) % 6]
            points += [(start + (end - start) * step / ring) * ring / rings for step in range(ring)]
    flat = np.array(points)
    front = np.column_stack([flat, np.zeros(len(flat))])
    return front - [0.0, 0.0, CELL_THICKNESS_M], front


def hinge_gaps(
    link_from_cell: NDArray[np.float64],
    cell_a: NDArray[np.integer],
    port_a: NDArray[np.integer],
    cell_b: NDArray[np.integer],
    port_b: NDArray[np.integer],
) -> NDArray[np.float64]:
    """Distance between the two hinge points of each edge; zero where t = a_p - R a_q holds.

    Args:
        link_from_cell: (N, 4, 4) poses of cells on one link.
        cell_a: (E,) cell index; port_a: (E,) port index 0 to 3; cell_b, port_b likewise.
        port_a: see cell_a.
        cell_b: see cell_a.
        port_b: see cell_a.

    Returns:
        (E,) metres.
    """
    point_a = (
        np.einsum("eij,ej->ei", link_from_cell[cell_a, :3, :3], PORT_POINTS_M[port_a]) + link_from_cell[cell_a, :3, 3]
    )
    point_b = (
        np.einsum("eij,ej->ei", link_from_cell[cell_b, :3, :3], PORT_POINTS_M[port_b]) + link_from_cell[cell_b, :3, 3]
    )
    return np.linalg.norm(point_a - point_b, axis=1)


def prism_overlap(pose_a: NDArray[np.float64], pose_b: NDArray[np.float64]) -> NDArray[np.float64]:
    """Penetration depth of pairs of cell prisms by the separating-axis theorem.

    Candidate axes: the four face normals of each prism (three pairs of flats, front) and the 16 cross products of
    their edge directions.

    Args:
        pose_a: (M, 4, 4) and pose_b: (M, 4, 4), both in the same frame.
        pose_b: see pose_a.

    Returns:
        (M,) metres; positive is the least overlap over all axes, negative is a gap along the best axis.
    """
    rotation_a, rotation_b = pose_a[:, :3, :3], pose_b[:, :3, :3]
    axes_a = FACE_NORMALS @ rotation_a.transpose(0, 2, 1)
    axes_b = FACE_NORMALS @ rotation_b.transpose(0, 2, 1)
    edges_a = EDGE_DIRECTIONS @ rotation_a.transpose(0, 2, 1)
    edges_b = EDGE_DIRECTIONS @ rotation_b.transpose(0, 2, 1)
    # Cross product of each pair of edges, written out: numpy's own is several times slower on small arrays.
    first, second = edges_a[:, :, None, :], edges_b[:, None, :, :]
    cross = first[..., [1, 2, 0]] * second[..., [2, 0, 1]] - first[..., [2, 0, 1]] * second[..., [1, 2, 0]]
    cross = cross.reshape(len(pose_a), -1, 3)
    length = np.sqrt((cross**2).sum(axis=2, keepdims=True))
    # Parallel edges give no axis; the z normal, already in the list, stands in for them.
    cross = np.where(length > 1e-6, cross / np.maximum(length, 1e-12), axes_a[:, 3:4])
    axes = np.concatenate([axes_a, axes_b, cross], axis=1)
    corners_a = PRISM_CORNERS_M @ rotation_a.transpose(0, 2, 1) + pose_a[:, None, :3, 3]
    corners_b = PRISM_CORNERS_M @ rotation_b.transpose(0, 2, 1) + pose_b[:, None, :3, 3]
    along_a = axes @ corners_a.transpose(0, 2, 1)
    along_b = axes @ corners_b.transpose(0, 2, 1)
    depth = np.minimum(along_a.max(2) - along_b.min(2), along_b.max(2) - along_a.min(2))
    return depth.min(axis=1)
