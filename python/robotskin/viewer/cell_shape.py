# SPDX-License-Identifier: Apache-2.0
"""The body of a cell as a mesh, and where the cells of a link stand."""

from itertools import pairwise

import numpy as np
from numpy.typing import NDArray
from scipy.spatial.transform import Rotation

from robotskin.layout.cell import CELL_THICKNESS_M, HEXAGON_M, HEXAGON_SIDE_M
from robotskin.viewer.session_view import Floats

Triangles = tuple[NDArray[np.float32], NDArray[np.uint32]]

BEVEL_M = 0.0009


def hexagon(scale: float, z: float) -> NDArray[np.float64]:
    """(6, 3) the corners of a cell times `scale`, at height z, anticlockwise seen from +z."""
    return np.column_stack([HEXAGON_M * scale, np.full(6, z)])


def hexagonal_prism() -> Triangles:
    """A cell in its own frame, in metres: outer face at z = 0, its rim broken by a bevel that catches the light.

    Returns vertices (V, 3) and faces (F, 3), each face with vertices of its own so that edges stay sharp.
    """
    inner = 1.0 - BEVEL_M / HEXAGON_SIDE_M
    rings = [hexagon(1.0, -CELL_THICKNESS_M), hexagon(1.0, -BEVEL_M), hexagon(inner, 0.0)]
    triangles = []
    for lower, upper in pairwise(rings):
        for corner in range(6):
            following = (corner + 1) % 6
            triangles += [
                (lower[corner], lower[following], upper[following]),
                (lower[corner], upper[following], upper[corner]),
            ]
    top, bottom = rings[-1], rings[0]
    for corner in range(1, 5):
        triangles += [(top[0], top[corner], top[corner + 1]), (bottom[0], bottom[corner + 1], bottom[corner])]
    vertices = np.asarray(triangles, dtype=np.float32).reshape(-1, 3)
    return vertices, np.arange(len(vertices), dtype=np.uint32).reshape(-1, 3)


def wxyz_position(a_from_b: Floats) -> tuple[Floats, Floats]:
    """Unit quaternions (..., 4), scalar first, and translations (..., 3) of poses (..., 4, 4)."""
    a_from_b = np.asarray(a_from_b, dtype=float)
    wxyz = Rotation.from_matrix(a_from_b[..., :3, :3].reshape(-1, 3, 3)).as_quat(scalar_first=True)
    return wxyz.reshape(*a_from_b.shape[:-2], 4), a_from_b[..., :3, 3]


def base_from_cell(base_from_link: Floats, link: NDArray[np.intp], link_from_cell: Floats) -> NDArray[np.float64]:
    """(N, 4, 4) poses of cells from poses (L, 4, 4) of links, the link (N,) of each cell and its pose on it."""
    return np.asarray(base_from_link, dtype=float)[link] @ np.asarray(link_from_cell, dtype=float)
