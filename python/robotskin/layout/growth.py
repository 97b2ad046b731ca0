# SPDX-License-Identifier: Apache-2.0
"""Growing a lattice of cells over a surface from one first cell, ring by ring, by the hinge rule."""

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.sparse import coo_matrix
from scipy.sparse.csgraph import connected_components
from scipy.spatial import cKDTree

from robotskin.layout.cell import (
    FLAT_PARTNER,
    HINGE_REACH_M,
    PORT_POINTS_M,
    PORTS,
    hinge_gaps,
)
from robotskin.layout.relax import close_pairs, overlapping_pairs, relax, tangent_poses, turn_to
from robotskin.layout.surface import Surface

Array = NDArray[np.float64]
Acceptance = Callable[[Array], NDArray[np.bool_]]
"""(N, 4, 4) poses in the link frame -> (N,) True where a cell may lie."""

SAME_PLACE_M = 0.012
"""Two predictions nearer than this mean the same cell: less than half a pitch, more than a hinge's reach."""
CAPTURE_M = 0.007
"""Hinge points nearer than this are pulled together by relaxation; only those within reach stay connected."""
OVERLAP_LET_IN_M = 0.0015
"""Overlap with which a new cell may start."""


@dataclass
class Sheet:
    """Cells on one link and the edges between them.

    poses: (N, 4, 4) link_from_cell; edges: (E, 4) rows of cell, port index, cell, port index.
    """

    poses: Array
    edges: NDArray[np.int64]

    def keep(self, wanted: NDArray[np.bool_]) -> "Sheet":
        """The sheet of the wanted cells (N,) and the edges among them."""
        renumber = np.cumsum(wanted) - 1
        edges = self.edges[wanted[self.edges[:, 0]] & wanted[self.edges[:, 2]]].copy()
        edges[:, [0, 2]] = renumber[edges[:, [0, 2]]]
        return Sheet(self.poses[wanted], edges)

    def gaps(self) -> Array:
        """(E,) hinge gaps, metres."""
        return hinge_gaps(self.poses, *self.edges.T)

    def components(self) -> tuple[int, NDArray[np.int32]]:
        """Number of connected components and the component of each cell (N,)."""
        count = len(self.poses)
        ones = np.ones(len(self.edges))
        return connected_components(
            coo_matrix((ones, (self.edges[:, 0], self.edges[:, 2])), shape=(count, count)), directed=False
        )


def connect(poses: Array, edges: NDArray[np.int64], reach: float) -> NDArray[np.int64]:
    """Add an edge for every pair of free ports that are each other's nearest within reach and face each other.

    Returns:
        (E, 4) all edges; each pair of cells has one edge at most.
    """
    count = len(poses)
    points = poses[:, None, :3, 3] + np.einsum("nij,pj->npi", poses[:, :3, :3], PORT_POINTS_M)
    outward = points - poses[:, None, :3, 3]
    taken = np.zeros((count, PORTS), dtype=bool)
    taken[edges[:, 0], edges[:, 1]] = True
    taken[edges[:, 2], edges[:, 3]] = True
    free = np.argwhere(~taken)
    if len(free) < 2:
        return edges
    joined = {(min(a, b), max(a, b)) for a, b in edges[:, [0, 2]].tolist()}
    free_points = points[free[:, 0], free[:, 1]]
    pairs = cKDTree(free_points).query_pairs(reach, output_type="ndarray")
    if len(pairs) == 0:
        return edges
    distance = np.linalg.norm(free_points[pairs[:, 0]] - free_points[pairs[:, 1]], axis=1)
    added = []
    used = np.zeros(len(free), dtype=bool)
    for index in np.argsort(distance, kind="stable"):
        first, second = pairs[index]
        (cell_a, port_a), (cell_b, port_b) = free[first], free[second]
        key = (min(cell_a, cell_b), max(cell_a, cell_b))
        if cell_a == cell_b or used[first] or used[second] or key in joined:
            continue
        direction_a, direction_b = outward[cell_a, port_a], outward[cell_b, port_b]
        if direction_a @ direction_b > 0.3 * np.linalg.norm(direction_a) * np.linalg.norm(direction_b):
            continue
        used[first] = used[second] = True
        joined.add(key)
        added.append([cell_a, port_a, cell_b, port_b])
    return np.concatenate([edges, np.array(added, dtype=np.int64).reshape(-1, 4)])


def predict(poses: Array, ports: NDArray[np.int64], surface: Surface) -> Array:
    """Where the hinge rule t = a_p - R a_q puts the neighbour at a port (index) of each cell."""
    hinge = poses[:, :3, 3] + np.einsum("nij,nj->ni", poses[:, :3, :3], PORT_POINTS_M[ports])
    points, normals = surface.project(2 * hinge - poses[:, :3, 3])
    for _ in range(2):
        found = tangent_poses(points, normals, turn_to(poses, normals))
        partner = np.einsum("nij,nj->ni", found[:, :3, :3], PORT_POINTS_M[FLAT_PARTNER[ports]])
        points, normals = surface.project(hinge - partner)
    return tangent_poses(points, normals, turn_to(poses, normals))


def merge(poses: Array) -> tuple[Array, NDArray[np.int64]]:
    """Predictions of the same place become one: mean poses (M, 4, 4) and how many predicted each (M,)."""
    pairs = close_pairs(poses, SAME_PLACE_M)
    count = len(poses)
    graph = coo_matrix((np.ones(len(pairs)), (pairs[:, 0], pairs[:, 1])), shape=(count, count))
    groups, label = connected_components(graph, directed=False)
    support = np.bincount(label, minlength=groups)
    mean = np.zeros((groups, 4, 4))
    np.add.at(mean, label, poses)
    mean /= support[:, None, None]
    normals = mean[:, :3, 2] / np.maximum(np.linalg.norm(mean[:, :3, 2], axis=1, keepdims=True), 1e-12)
    return tangent_poses(mean[:, :3, 3], normals, mean[:, :3, 0]), support


def grow(surface: Surface, accept: Acceptance, first: Array, limit: int = 4000) -> Sheet:
    """Grow a sheet breadth first from one pose until no free port leads to an acceptable place.

    Args:
        surface: of the link.
        accept: which poses are allowed (clear of the neighbouring links, not inside the mesh).
        first: (4, 4) pose of the first cell.
        limit: most cells; beyond it the growth stops.
    """
    poses = first[None].copy()
    edges = np.zeros((0, 4), dtype=np.int64)
    tried = np.zeros((1, PORTS), dtype=bool)
    while len(poses) < limit:
        open_port = ~tried
        open_port[edges[:, 0], edges[:, 1]] = False
        open_port[edges[:, 2], edges[:, 3]] = False
        cells, ports = np.nonzero(open_port)
        if len(cells) == 0:
            break
        tried[cells, ports] = True
        candidates, support = merge(predict(poses[cells], ports, surface))
        points, normals = surface.project(candidates[:, :3, 3])
        candidates = tangent_poses(points, normals, candidates[:, :3, 0])
        allowed = np.isfinite(candidates).all(axis=(1, 2)) & accept(candidates)
        candidates, support = candidates[allowed], support[allowed]
        # A little overlap is let in: relaxation, which follows at once, can push it out.
        pairs, _ = overlapping_pairs(np.concatenate([poses, candidates]), -OVERLAP_LET_IN_M)
        refused = np.zeros(len(poses) + len(candidates), dtype=bool)
        rivals: dict[int, list[int]] = {}
        for a, b in np.sort(pairs, axis=1).tolist():
            if a < len(poses) <= b:
                refused[b] = True
            elif a >= len(poses):
                rivals.setdefault(a, []).append(b)
                rivals.setdefault(b, []).append(a)
        for index in (np.argsort(-support, kind="stable") + len(poses)).tolist():
            if not refused[index]:
                refused[rivals.get(index, [])] = True
        chosen = candidates[~refused[len(poses) :]]
        edges = connect(poses, edges, CAPTURE_M)
        if len(chosen) == 0:
            continue
        poses = np.concatenate([poses, chosen])
        tried = np.concatenate([tried, np.zeros((len(chosen), PORTS), dtype=bool)])
        edges = connect(poses, edges, CAPTURE_M)
        poses = relax(poses, edges, surface, iterations=2)
    return settle(Sheet(poses, edges), surface, accept)


def settle(sheet: Sheet, surface: Surface, accept: Acceptance) -> Sheet:
    """Relax to rest, then take out what breaks a law: too wide edges, overlapping cells, unallowed cells."""
    sheet = Sheet(relax(sheet.poses, sheet.edges, surface, iterations=15), sheet.edges)
    for _ in range(12):
        gaps = sheet.gaps()
        too_wide = gaps > HINGE_REACH_M
        pairs, depth = overlapping_pairs(sheet.poses)
        unallowed = ~accept(sheet.poses)
        if not too_wide.any() and not len(pairs) and not unallowed.any():
            break
        # The worst first: each one that goes lets its neighbours relax.
        edges = sheet.edges[~(too_wide & (gaps >= 0.7 * gaps.max()))] if too_wide.any() else sheet.edges
        degree = np.bincount(edges[:, [0, 2]].ravel(), minlength=len(sheet.poses))
        wanted = ~unallowed
        for a, b in pairs[np.argsort(-depth, kind="stable")]:
            if wanted[a] and wanted[b]:
                wanted[a if degree[a] < degree[b] else b] = False
        sheet = Sheet(sheet.poses, edges).keep(wanted)
        sheet.edges = connect(sheet.poses, sheet.edges, HINGE_REACH_M)
        sheet = Sheet(relax(sheet.poses, sheet.edges, surface, iterations=6), sheet.edges)
    gaps = sheet.gaps()
    sheet = Sheet(sheet.poses, sheet.edges[gaps <= HINGE_REACH_M])
    pairs, _ = overlapping_pairs(sheet.poses)
    wanted = accept(sheet.poses)
    for a, b in pairs:
        if wanted[a] and wanted[b]:
            wanted[b] = False
    return sheet.keep(wanted)
