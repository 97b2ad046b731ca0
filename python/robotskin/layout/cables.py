# SPDX-License-Identifier: Apache-2.0
"""Studs and cables (paper, II-E): where patches are tied to the robot, and how cables reach the section unit."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np
import pinocchio
import trimesh
from numpy.typing import NDArray
from scipy.sparse import csr_matrix
from scipy.sparse.csgraph import dijkstra
from scipy.spatial import cKDTree

from robotskin.layout.cell import PORT_POINTS_M
from robotskin.layout.clearance import link_joint, postures
from robotskin.layout.layout import Cable, Layout, Stud

if TYPE_CHECKING:
    from robotskin.robots import Robot

Array = NDArray[np.float64]
Point = tuple[float, float, float]

STUD_SPACING_M = 0.08
FEWEST_STUDS = 3
MOST_STUDS = 12
CROSSING_REACH_M = 0.12
"""How far from a joint's centre a cable may leave the surface to cross the joint."""
SURFACE_POINTS = 1500


def _point(values: Array) -> Point:
    return tuple(np.round(values, 6).tolist())  # type: ignore[return-value]


def plan_studs(layout: Layout, robot: Robot) -> tuple[Stud, ...]:
    """Anchor points around each patch, on the link's mesh, one about every 80 mm of the patch's rim.

    A stud stands where the lattice would have its next cell beyond a free port of the rim, so that the elastics pull
    outward; among these places those farthest from each other are taken.
    """
    studs = []
    for number, patch in enumerate(layout.patches):
        cells = np.flatnonzero(layout.patch == number)
        free_cell, free_port = np.nonzero(layout.neighbours[cells, :, 0] < 0)
        poses = layout.link_from_cell[cells[free_cell]]
        beyond = poses[:, :3, 3] + 2 * np.einsum("nij,nj->ni", poses[:, :3, :3], PORT_POINTS_M[free_port])
        mesh = robot.link_mesh(patch.link)
        points, _, triangle = trimesh.proximity.closest_point(mesh, beyond)
        distance = cKDTree(layout.link_from_cell[layout.cells_on(patch.link), :3, 3]).query(points)[0]
        count = int(np.clip(round(len(points) * 0.028 / STUD_SPACING_M), FEWEST_STUDS, MOST_STUDS))
        # The first is the one that is clearest of all cells.
        chosen = [int(np.argmax(distance))]
        while len(chosen) < min(count, len(points)):
            away = np.min([np.linalg.norm(points - points[stud], axis=1) for stud in chosen], axis=0)
            chosen.append(int(np.argmax(away)))
        studs += [Stud(number, patch.link, _point(points[i]), _point(mesh.face_normals[triangle[i]])) for i in chosen]
    return tuple(studs)


@dataclass(frozen=True)
class Crossing:
    """A cable's straight way across a joint (or several without a mesh): its two ends and its length, metres."""

    child: str
    parent: str
    child_point: Array
    parent_point: Array
    neutral: float
    shortest: float
    longest: float


def meshed_parent(robot: Robot, link: str) -> tuple[str, list[int]] | None:
    """The next link with a mesh towards the base, and the joints between; None at the last one."""
    model = robot.model
    meshed = robot.links_with("collision")
    here = link_joint(robot, link)
    path: list[int] = []
    while here > 0:
        path.append(here)
        here = int(model.parents[here])
        at_joint = [name for name in meshed if link_joint(robot, name) == here]
        if at_joint:
            return at_joint[-1], path
    return None


def cross(robot: Robot, child: str, parent: str, path: list[int], seed: int) -> Crossing:
    """The pair of surface points beside a joint whose distance changes least over the joint range, then is least."""
    model = robot.model
    data = model.createData()
    frame_child, frame_parent = model.getBodyId(child), model.getBodyId(parent)

    def child_from_parent(q: Array) -> Array:
        pinocchio.forwardKinematics(model, data, q)
        pinocchio.updateFramePlacement(model, data, frame_child)
        pinocchio.updateFramePlacement(model, data, frame_parent)
        return (data.oMf[frame_child].inverse() * data.oMf[frame_parent]).homogeneous

    neutral = child_from_parent(robot.neutral)
    transforms = np.array([neutral, *(child_from_parent(q) for q in postures(model, path, seed))])
    ends = []
    pinocchio.forwardKinematics(model, data, robot.neutral)
    pinocchio.updateFramePlacements(model, data)
    joint_centre = data.oMi[path[0]].translation
    for name in (child, parent):
        points, _ = trimesh.sample.sample_surface(robot.link_mesh(name), 600, seed=seed)
        centre = data.oMf[model.getBodyId(name)].actInv(joint_centre)
        distance = np.linalg.norm(points - centre, axis=1)
        ends.append(points[np.argsort(distance, kind="stable")[:60]])
        near = ends[-1][np.linalg.norm(ends[-1] - centre, axis=1) < CROSSING_REACH_M]
        ends[-1] = near if len(near) else ends[-1][:1]
    moved = np.einsum("qij,bj->qbi", transforms[:, :3, :3], ends[1]) + transforms[:, None, :3, 3]
    lengths = np.linalg.norm(ends[0][None, :, None] - moved[:, None], axis=3)
    shortest, longest = lengths.min(axis=0), lengths.max(axis=0)
    a, b = np.unravel_index(int(np.argmin(3 * (longest - shortest) + longest)), longest.shape)
    rest = float(np.linalg.norm(ends[0][a] - (neutral[:3, :3] @ ends[1][b] + neutral[:3, 3])))
    return Crossing(child, parent, ends[0][a], ends[1][b], rest, float(shortest[a, b]), float(longest[a, b]))


class SurfaceWays:
    """Lengths of ways over a link's surface, through a graph of sampled points."""

    def __init__(self, mesh: trimesh.Trimesh, seed: int) -> None:
        self.points, _ = trimesh.sample.sample_surface(mesh, SURFACE_POINTS, seed=seed)
        self.tree = cKDTree(self.points)
        distance, other = self.tree.query(self.points, k=9)
        rows = np.repeat(np.arange(SURFACE_POINTS), 8)
        self.graph = csr_matrix((distance[:, 1:].ravel(), (rows, other[:, 1:].ravel())), shape=(SURFACE_POINTS,) * 2)

    def length(self, start: Array, end: Array) -> float:
        """Metres from start to end (3,) each; straight where the mesh has no connection between them."""
        (first, last), (source, target) = self.tree.query([start, end])
        way = float(dijkstra(self.graph, directed=False, indices=source)[target])
        straight = float(np.linalg.norm(end - start))
        return max(straight, first + way + last) if np.isfinite(way) else straight


def plan_cables(layout: Layout, robot: Robot, seed: int = 0) -> tuple[Cable, ...]:
    """Route each section-unit port's cable to the section unit beside the first joint.

    On a link a cable follows the surface; across a joint it runs straight, in a channel, between two points chosen so
    that its length changes least. Lengths over the joint range are sums of each crossing's least and greatest length.
    """
    crossings: dict[str, Crossing | None] = {}
    ways: dict[str, SurfaceWays] = {}
    cables = []
    for place in layout.section_unit_ports:
        pose = layout.link_from_cell[place.cell]
        link = layout.links[layout.link[place.cell]]
        here = pose[:3, 3] + pose[:3, :3] @ PORT_POINTS_M[place.cell_port - 1]
        route: list[tuple[str, Point]] = [(link, _point(here))]
        fixed = neutral = shortest = longest = 0.0
        while True:
            if link not in crossings:
                step = meshed_parent(robot, link)
                crossings[link] = cross(robot, link, *step, seed) if step else None
            crossing = crossings[link]
            if crossing is None:
                break
            if link not in ways:
                ways[link] = SurfaceWays(robot.link_mesh(link), seed)
            fixed += ways[link].length(here, crossing.child_point)
            neutral += crossing.neutral
            shortest += crossing.shortest
            longest += crossing.longest
            route += [(link, _point(crossing.child_point)), (crossing.parent, _point(crossing.parent_point))]
            link, here = crossing.parent, crossing.parent_point
        total = fixed + neutral
        stretch = (fixed + longest) / total - 1 if total > 0 else 0.0
        cables.append(
            Cable(
                place.group,
                place.port,
                tuple(route),
                round(total, 6),
                round(fixed + shortest, 6),
                round(fixed + longest, 6),
                round(stretch, 6),
            )
        )
    return tuple(cables)
