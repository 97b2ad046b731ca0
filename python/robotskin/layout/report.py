# SPDX-License-Identifier: Apache-2.0
"""What a covering achieves, link by link: area covered, hinge gaps, edges left open, overhang and room."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np
from scipy.spatial import cKDTree

from robotskin.layout.cell import HINGE_REACH_M, PORT_POINTS_M
from robotskin.layout.layout import Layout
from robotskin.layout.places import LinkPlaces

OPEN_EDGE_M = 0.010
"""Free ports that face each other within this distance are neighbours whose joint cannot reach."""


@dataclass(frozen=True)
class LinkReport:
    """SI units. coverable_area: of the smooth surface where skin is clear of the neighbouring links, m^2; coverage: the
    share of it under cells and their joints; gap_mean, gap_worst: of connected hinges, m; edges: connected;
    open_edges: facing ports farther apart than the hinge reaches; overhanging: cells of whose back more than a tenth
    stands off the mesh; worst_overhang: share of the back; least_foam, least_room: m.
    """

    link: str
    cells: int
    patches: int
    coverable_area: float
    coverage: float
    edges: int
    gap_mean: float
    gap_worst: float
    open_edges: int
    overhanging: int
    worst_overhang: float
    least_foam: float
    least_room: float


def open_edges(layout: Layout, link: str) -> int:
    """Pairs of free ports that face each other but whose hinge points the joint cannot span."""
    cells = layout.cells_on(link)
    free_cell, free_port = np.nonzero(layout.neighbours[cells, :, 0] < 0)
    if len(free_cell) < 2:
        return 0
    poses = layout.link_from_cell[cells[free_cell]]
    outward = np.einsum("nij,nj->ni", poses[:, :3, :3], PORT_POINTS_M[free_port])
    points = poses[:, :3, 3] + outward
    pairs = cKDTree(points).query_pairs(OPEN_EDGE_M, output_type="ndarray").reshape(-1, 2)
    facing = np.einsum("ni,ni->n", outward[pairs[:, 0]], outward[pairs[:, 1]]) < 0
    apart = np.linalg.norm(points[pairs[:, 0]] - points[pairs[:, 1]], axis=1) > HINGE_REACH_M
    return int(np.sum(facing & apart & (free_cell[pairs[:, 0]] != free_cell[pairs[:, 1]])))


def report(layout: Layout, places: Mapping[str, LinkPlaces]) -> list[LinkReport]:
    """Measure a covering.

    Args:
        layout: the covering.
        places: for each of its links, as `cover` returns them.
    """
    rows = []
    edges, gaps = layout.hinge_edges(), layout.gaps()
    for link, place in places.items():
        cells = layout.cells_on(link)
        poses = layout.link_from_cell[cells]
        mine = layout.link[edges[:, 0]] == layout.links.index(link)
        coverable = place.coverable
        covered = place.covered(poses) & coverable
        overhang = place.overhang(poses) if len(cells) else np.zeros(1)
        rows.append(
            LinkReport(
                link,
                len(cells),
                len(np.unique(layout.patch[cells])),
                float(coverable.sum() * place.sample_area),
                float(covered.sum() / max(1, coverable.sum())),
                int(mine.sum()),
                float(gaps[mine].mean()) if mine.any() else 0.0,
                float(gaps[mine].max()) if mine.any() else 0.0,
                open_edges(layout, link),
                int(np.sum(overhang > 0.1)),
                float(overhang.max()),
                float(place.least_foam(poses).min()) if len(cells) else np.inf,
                float(place.room(poses).min()) if len(cells) else np.inf,
            )
        )
    return rows
