# SPDX-License-Identifier: Apache-2.0
"""Relaxation: hinge gaps spread over a patch and overlapping cells pushed apart, every cell kept on its surface."""

import numpy as np
from numpy.typing import NDArray
from scipy import sparse
from scipy.sparse.linalg import spsolve
from scipy.spatial import cKDTree

from robotskin.layout.cell import HEXAGON_SIDE_M, PORT_POINTS_M, prism_overlap
from robotskin.layout.surface import Surface

Array = NDArray[np.float64]

OVERLAP_MARGIN_M = 0.0004
"""Distance that relaxation leaves between two prisms, so that a later rounding cannot make them touch."""


def tangent_poses(points: Array, normals: Array, x_hint: Array) -> Array:
    """(N, 4, 4) poses at points (N, 3) with z along normals (N, 3) and x next to x_hint (N, 3)."""
    x_axis = x_hint - np.sum(x_hint * normals, axis=1, keepdims=True) * normals
    x_axis /= np.maximum(np.linalg.norm(x_axis, axis=1, keepdims=True), 1e-12)
    poses = np.zeros((len(points), 4, 4))
    poses[:, :3, 0] = x_axis
    poses[:, :3, 1] = np.cross(normals, x_axis)
    poses[:, :3, 2] = normals
    poses[:, :3, 3] = points
    poses[:, 3, 3] = 1.0
    return poses


def turn_to(poses: Array, normals: Array) -> Array:
    """(N, 3) x axes of poses (N, 4, 4) carried to new normals (N, 3) by the smallest rotation (parallel transport)."""
    old, x_axis = poses[:, :3, 2], poses[:, :3, 0]
    axis = np.cross(old, normals)
    cosine = np.sum(old * normals, axis=1, keepdims=True)
    along = np.sum(axis * x_axis, axis=1, keepdims=True)
    return cosine * x_axis + np.cross(axis, x_axis) + axis * along / np.maximum(1.0 + cosine, 1e-9)


def close_pairs(poses: Array, reach: float = 2 * HEXAGON_SIDE_M) -> NDArray[np.int64]:
    """(M, 2) index pairs of cells whose centres are nearer than reach: no others can overlap."""
    if len(poses) < 2:
        return np.zeros((0, 2), dtype=np.int64)
    return cKDTree(poses[:, :3, 3]).query_pairs(reach, output_type="ndarray").astype(np.int64)


def overlapping_pairs(poses: Array, margin: float = 0.0) -> tuple[NDArray[np.int64], Array]:
    """Pairs of cells whose prisms are nearer than margin: (M, 2) indices and (M,) depths, metres."""
    pairs = close_pairs(poses, 2 * HEXAGON_SIDE_M + margin)
    depth = prism_overlap(poses[pairs[:, 0]], poses[pairs[:, 1]]) if len(pairs) else np.zeros(0)
    wanted = depth > -margin
    return pairs[wanted], depth[wanted]


def relax(
    poses: Array, edges: NDArray[np.int64], surface: Surface, iterations: int = 8, pinned: int | None = None
) -> Array:
    """Gauss-Newton over two shifts in the tangent plane and one turn about the normal of every cell.

    Minimises the sum of squared hinge gaps |h_p - h_q|^2 with a stiff penalty on overlap. After each step the cells
    are projected to the surface again and turned with its normal.

    Args:
        poses: (N, 4, 4) in the link frame.
        edges: (E, 4) rows of cell, port index, cell, port index.
        surface: what the cells lie on.
        iterations: of Gauss-Newton; eight bring a ring of new cells to rest.
        pinned: a cell that stays where it is.
    """
    count = len(poses)
    for _ in range(iterations if count > 1 else 0):
        rotation, place = poses[:, :3, :3], poses[:, :3, 3]
        cell_a, port_a, cell_b, port_b = edges.T
        lever_a = np.einsum("eij,ej->ei", rotation[cell_a], PORT_POINTS_M[port_a])
        lever_b = np.einsum("eij,ej->ei", rotation[cell_b], PORT_POINTS_M[port_b])
        gap = place[cell_a] + lever_a - place[cell_b] - lever_b
        rows: list[Array] = []
        columns: list[Array] = []
        values: list[Array] = []

        def add(
            first_row: int, cells: NDArray[np.int64], jacobian: Array, *, out: tuple = (rows, columns, values)
        ) -> None:
            # jacobian: (E, R, 3), R residual rows of each of E cells.
            height = jacobian.shape[1]
            row = first_row + np.arange(len(cells) * height).reshape(len(cells), height, 1)
            out[0].append(np.broadcast_to(row, jacobian.shape).ravel())
            out[1].append(np.broadcast_to(3 * cells[:, None, None] + np.arange(3), jacobian.shape).ravel())
            out[2].append(jacobian.ravel())

        def hinge_jacobian(cells: NDArray[np.int64], lever: Array, rotation: Array = rotation) -> Array:
            turn = np.cross(rotation[cells][:, :, 2], lever)
            return np.concatenate([rotation[cells][:, :, :2], turn[:, :, None] / HEXAGON_SIDE_M], axis=2)

        add(0, cell_a, hinge_jacobian(cell_a, lever_a))
        add(0, cell_b, -hinge_jacobian(cell_b, lever_b))
        residual = [gap.ravel()]
        pairs, depth = overlapping_pairs(poses, OVERLAP_MARGIN_M)
        if len(pairs):
            apart = place[pairs[:, 0]] - place[pairs[:, 1]]
            apart /= np.maximum(np.linalg.norm(apart, axis=1, keepdims=True), 1e-9)
            stiffness = 3.0
            for side, sign in ((0, 1.0), (1, -1.0)):
                jacobian = np.zeros((len(pairs), 1, 3))
                jacobian[:, 0, :2] = (
                    -sign * stiffness * np.einsum("mi,mij->mj", apart, rotation[pairs[:, side]][:, :, :2])
                )
                add(3 * len(edges), pairs[:, side], jacobian)
            residual.append(stiffness * (depth + OVERLAP_MARGIN_M))
        error = np.concatenate(residual)
        jacobian_all = sparse.csr_matrix(
            (np.concatenate(values), (np.concatenate(rows), np.concatenate(columns))), shape=(len(error), 3 * count)
        )
        damping = np.full(3 * count, 0.02)
        if pinned is not None:
            damping[3 * pinned : 3 * pinned + 3] = 1e6
        normal_matrix = (jacobian_all.T @ jacobian_all + sparse.diags(damping)).tocsc()
        step = spsolve(normal_matrix, -(jacobian_all.T @ error)).reshape(-1, 3)
        # A step beyond 4 mm leaves what the linearisation knows.
        step *= np.minimum(1.0, 0.004 / np.maximum(np.abs(step).max(axis=1, keepdims=True), 1e-12))
        moved = place + np.einsum("nij,nj->ni", rotation[:, :, :2], step[:, :2])
        angle = step[:, 2:3] / HEXAGON_SIDE_M
        poses = poses.copy()
        poses[:, :3, 0] = np.cos(angle) * rotation[:, :, 0] + np.sin(angle) * rotation[:, :, 1]
        points, normals = surface.project(moved, 2)
        poses = tangent_poses(points, normals, turn_to(poses, normals))
    return poses
