# SPDX-License-Identifier: Apache-2.0
"""Where on a link cells may lie, and how well a set of cells uses the room there is."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from robotskin.layout.cell import CELL_THICKNESS_M, LATTICE_CELL_AREA_M2, prism_points
from robotskin.layout.clearance import Clearance
from robotskin.layout.surface import LinkSurface

Array = NDArray[np.float64]


@dataclass(frozen=True)
class Rules:
    """What a place for a cell must satisfy; lengths in metres.

    foam: between the robot and the cell's back. clearance: between a cell and a neighbouring link at any joint
    position. least_foam: what compressed foam leaves between the mesh and a cell's back. overhang_distance: a point of
    the back that stands farther than foam plus this off the mesh hangs over. most_overhang: share of the back that may.
    least_patch: patches with fewer cells are not mounted. facing, angle_deg: cells look along this direction of the
    link frame, within the angle; None: anywhere.
    """

    foam: float = 0.003
    clearance: float = 0.003
    least_foam: float = 0.0005
    overhang_distance: float = 0.006
    most_overhang: float = 0.35
    least_patch: int = 3
    facing: tuple[float, float, float] | None = None
    angle_deg: float = 30.0

    def faces(self, normals: Array) -> NDArray[np.bool_]:
        """(N,) True for those of the unit normals (N, 3) along which a cell may look."""
        if self.facing is None:
            return np.ones(len(normals), dtype=bool)
        wanted = np.asarray(self.facing, dtype=float) / np.linalg.norm(self.facing)
        return normals @ wanted >= np.cos(np.radians(self.angle_deg)) - 1e-9


@dataclass(frozen=True)
class Area:
    """A part of a link that gets its cells first, and exactly so many.

    facing, angle_deg: where they look, in the link frame. at_m: the point of the link frame at which, on the surface,
    the middle of the first cell lies; None: wherever most cells fit. rules: of these places, other than the link's.
    """

    link: str
    cells: int
    facing: tuple[float, float, float]
    angle_deg: float = 30.0
    at_m: tuple[float, float, float] | None = None
    rules: Rules | None = None

    def flaw(self) -> str:
        """What makes it no area, and what would be right; empty where nothing does."""
        shown = ",".join(f"{part:g}" for part in self.facing)
        if self.cells < 1:
            return f"{self.cells} cells: at least one"
        if not np.isfinite(self.facing).all():
            return f"direction {shown}: its numbers must be finite"
        if not np.linalg.norm(self.facing) > 0:
            return f"direction {shown}: it has no length; 1,0,0 is the x axis of the link"
        if not 0 < self.angle_deg <= 180:
            return f"{self.angle_deg:g} degrees: above 0, and 180 at most"
        return ""

    def rules_on(self, rules: Rules) -> Rules:
        """The rules of its places, where the link has these."""
        return replace(self.rules or rules, facing=self.facing, angle_deg=self.angle_deg, least_patch=1)


class LinkPlaces:
    """The places on one link where cells may lie, and how well a sheet of cells uses them."""

    def __init__(self, surface: LinkSurface, clearance: Clearance, rules: Rules, seed: int) -> None:
        self.surface, self.clearance, self.rules = surface, clearance, rules
        self.room_near = clearance.near(surface)
        self.back, self.front = prism_points()
        self.points, self.normals, self.sample_area = surface.samples(seed=seed)
        self.coverable = self._coverable()

    def _coverable(self) -> NDArray[np.bool_]:
        """(M,) surface samples over which the whole height of a skin is clear of the neighbouring links."""
        least = np.full(len(self.points), np.inf)
        for depth in (0.0, 0.5 * CELL_THICKNESS_M, CELL_THICKNESS_M):
            least = np.minimum(least, self.room_near.at(self.points - depth * self.normals))
        return (least > self.rules.clearance) & self.rules.faces(self.normals)

    def overhang(self, poses: Array) -> Array:
        """(N,) share of each cell's back that stands off the mesh by more than foam and the overhang distance."""
        stand_off = self.surface.raw.at(self._world(poses, self.back))
        return (stand_off > self.rules.foam + self.rules.overhang_distance).mean(axis=1)

    def least_foam(self, poses: Array) -> Array:
        """(N,) metres between the mesh and the nearest point of each cell's back; negative inside the mesh."""
        return self.surface.raw.at(self._world(poses, self.back)).min(axis=1)

    @staticmethod
    def _world(poses: Array, points: Array) -> Array:
        return np.einsum("nij,pj->npi", poses[:, :3, :3], points) + poses[:, None, :3, 3]

    def room(self, poses: Array, exact: bool = True) -> Array:
        """(N,) metres between each cell and the neighbouring links, least over the joint range."""
        points = self._world(poses, np.concatenate([self.back, self.front]))
        field = self.clearance if exact else self.room_near
        return field.at(points.reshape(-1, 3)).reshape(points.shape[:2]).min(axis=1)

    def accept(self, poses: Array, exact: bool = False) -> NDArray[np.bool_]:
        """(N,) True where a cell is outside the mesh, rests on it well enough and is clear of its neighbours."""
        good = (self.least_foam(poses) >= self.rules.least_foam) & (self.overhang(poses) <= self.rules.most_overhang)
        good &= self.rules.faces(poses[:, :3, 2])
        if good.any():
            good[good] = self.room(poses[good], exact) > self.rules.clearance
        return good

    def covered(self, poses: Array) -> NDArray[np.bool_]:
        """(M,) surface samples under the lattice hexagon (cell and its share of the joints) of some cell."""
        result = np.zeros(len(self.points), dtype=bool)
        grown = np.sqrt(LATTICE_CELL_AREA_M2 / (1.5 * np.sqrt(3.0)))
        normals = np.array([[np.cos(angle), np.sin(angle)] for angle in np.pi / 6 + np.arange(3) * np.pi / 3])
        for pose in poses:
            near = np.flatnonzero(np.sum((self.points - pose[:3, 3]) ** 2, axis=1) < 0.020**2)
            local = (self.points[near] - pose[:3, 3]) @ pose[:3, :3]
            flats = np.abs(local[:, :2] @ normals.T).max(axis=1)
            result[near[flats <= grown * np.sqrt(3.0) / 2]] = True
        return result
