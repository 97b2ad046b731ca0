# SPDX-License-Identifier: Apache-2.0
"""The surface on which cells lie: a link's mesh as a smooth signed distance field on a grid.

Meshes of robots have holes, inner walls and sharp grooves. A distance field that is closed (grooves narrower than a
cell are bridged) and smoothed over about half a cell gives every place one outward normal.
"""

from dataclasses import dataclass
from typing import Protocol

import numpy as np
import trimesh
from numpy.typing import NDArray
from scipy import ndimage

from robotskin.layout.errors import LayoutError

Array = NDArray[np.float64]


@dataclass(frozen=True)
class DistanceField:
    """Signed distance to a surface on a regular grid, negative inside, metres.

    value: (X, Y, Z); origin: (3,) metres, the centre of voxel (0, 0, 0); step: edge of a voxel, metres.
    """

    value: NDArray[np.float32]
    origin: Array
    step: float

    def at(self, points: Array) -> Array:
        """Distance at points (..., 3), metres; outside the grid the value at its rim plus the way there."""
        index = (points.reshape(-1, 3) - self.origin) / self.step
        limit = np.array(self.value.shape) - 1.0
        inside = np.clip(index, 0.0, limit)
        value = ndimage.map_coordinates(self.value, inside.T, order=1)
        value = value + np.linalg.norm(index - inside, axis=1) * self.step
        return value.reshape(points.shape[:-1])

    def gradient(self, points: Array) -> Array:
        """Unit gradient (outward normal) at points (N, 3) by central differences over a voxel."""
        offsets = np.concatenate([np.eye(3), -np.eye(3)]) * self.step
        value = self.at(points[:, None, :] + offsets)
        gradient = value[:, :3] - value[:, 3:]
        return gradient / np.maximum(np.linalg.norm(gradient, axis=1, keepdims=True), 1e-12)


def outside_of(occupied: NDArray[np.bool_]) -> NDArray[np.bool_]:
    """Voxels connected to the grid's rim through voxels that are not occupied."""
    labels, _ = ndimage.label(~occupied)
    return labels == labels[0, 0, 0]


def distance_field(mesh: trimesh.Trimesh, step: float, margin: float, seed: int = 0) -> DistanceField:
    """Signed distance to the outer skin of a mesh, exact near the surface.

    What cannot be reached from outside through openings wider than two voxels counts as inside.

    Args:
        mesh: metres; need not be watertight.
        step: voxel edge, metres.
        margin: grid beyond the mesh's box, metres.
        seed: of the surface samples.

    Raises:
        LayoutError: a mesh without area.
    """
    if len(mesh.faces) == 0 or not mesh.area > 0:
        raise LayoutError(f"mesh of {len(mesh.faces)} faces has area {mesh.area} m2: no surface to cover")
    low, high = mesh.bounds[0] - margin, mesh.bounds[1] + margin
    shape = np.ceil((high - low) / step).astype(int) + 1
    # Four samples or more for each voxel face: no voxel that the surface crosses is missed by more than chance allows.
    count = int(np.clip(mesh.area / (0.35 * step) ** 2, 2_000, 3_000_000))
    samples, face = trimesh.sample.sample_surface(mesh, count, seed=seed)
    voxel = np.round((samples - low) / step).astype(int)
    flat = np.ravel_multi_index(tuple(voxel.T), shape)
    hits = np.bincount(flat, minlength=int(np.prod(shape))).reshape(shape)
    occupied = hits > 0
    # Closing by one voxel shuts the seams between the parts of a mesh before the flood comes from outside.
    outside = outside_of(ndimage.binary_dilation(occupied))
    outside = ndimage.binary_dilation(outside, mask=~occupied)
    # Only what the outside touches counts, so that inner walls do not make a place look close to the surface.
    skin = occupied & ndimage.binary_dilation(outside, iterations=2)
    nearest = ndimage.distance_transform_edt(~skin, return_distances=False, return_indices=True)
    # Each voxel of the skin is represented by the mean of its samples, which is within the voxel of the true surface.
    mean = np.zeros((*shape, 3), dtype=np.float32)
    for axis in range(3):
        total = np.bincount(flat, weights=samples[:, axis], minlength=hits.size).reshape(shape)
        mean[..., axis] = total / np.maximum(hits, 1)
    squared = np.zeros(shape, dtype=np.float32)
    for axis, extent in enumerate(shape):
        centre = (low[axis] + step * np.arange(extent)).reshape([-1 if other == axis else 1 for other in range(3)])
        squared += (mean[..., axis][tuple(nearest)] - centre) ** 2
    distance = np.sqrt(squared)
    value = np.where(outside, distance, -distance).astype(np.float32)
    # A voxel that the surface crosses is neither inside nor outside: there the distance to the surface's plane is
    # right, with its side taken from the field around (normals of meshes cannot be trusted to point outward).
    slope = np.gradient(ndimage.gaussian_filter(value, 1.0))
    normals = mesh.face_normals[face]
    side = sum(slope[axis][tuple(voxel.T)] * normals[:, axis] for axis in range(3))
    normals = normals * np.where(side < 0, -1.0, 1.0)[:, None]
    near = (np.abs(value) < 1.8 * step) & (nearest >= 0).all(axis=0)
    source = tuple(index[near] for index in nearest)
    offset = np.argwhere(near) * step + low - mean[source]
    sums = [
        np.bincount(flat, weights=normals[:, axis], minlength=hits.size).reshape(shape)[source] for axis in range(3)
    ]
    plane_normal = np.stack(sums, axis=1) / np.maximum(hits[source], 1)[:, None]
    # Where normals of a voxel disagree there is an edge, and no plane.
    flatness = np.linalg.norm(plane_normal, axis=1)
    along = np.einsum("ni,ni->n", offset, plane_normal) / np.maximum(flatness, 1e-9)
    value[near] = np.where(flatness > 0.8, along, value[near])
    return DistanceField(value, low, step)


class Surface(Protocol):
    """What a lattice grows on."""

    def project(self, points: Array, iterations: int = 4) -> tuple[Array, Array]:
        """Points (N, 3) moved to where cells lie, and their unit normals (N, 3)."""


@dataclass(frozen=True)
class LinkSurface:
    """What a cell on a link needs to know of it; all in the link frame, metres.

    raw: distance to the mesh itself (used for clearance, foam and overhang).
    smooth: the closed and smoothed field (used for place and normal).
    height: distance of a cell's outer face from the smooth surface: foam plus cell thickness.
    """

    mesh: trimesh.Trimesh
    raw: DistanceField
    smooth: DistanceField
    height: float

    @classmethod
    def of(
        cls, mesh: trimesh.Trimesh, height: float, closing: float = 0.030, smoothing: float = 0.005, seed: int = 0
    ) -> "LinkSurface":
        """Build the fields of a link's mesh.

        Args:
            mesh: link frame, metres.
            height: metres, of a cell's outer face over the smooth surface.
            closing: radius of the ball that cannot enter the grooves it bridges, metres.
            smoothing: standard deviation of the Gaussian that rounds the field, metres.
            seed: of the surface samples.
        """
        margin = closing + 0.012
        # About a million voxels at most: the grid is as fine as the link is small, never finer than 1.5 mm.
        volume = float(np.prod(mesh.extents + 2 * margin))
        step = float(np.clip((volume / 1.2e6) ** (1 / 3), 0.0015, 0.005))
        raw = distance_field(mesh, step, margin, seed)
        beyond = raw.value > closing
        reach, nearest = ndimage.distance_transform_edt(~beyond, return_indices=True)
        # The voxel found lies a little beyond the radius, by what its own distance says.
        closed = np.where(beyond, raw.value, raw.value[tuple(nearest)] - reach * step)
        closed = np.minimum(closed, raw.value)
        smooth = ndimage.gaussian_filter(closed, smoothing / step, mode="nearest").astype(np.float32)
        return cls(mesh, raw, DistanceField(smooth, raw.origin, step), height)

    def normals(self, points: Array) -> Array:
        """(N, 3) unit outward normals of the smooth field at points (N, 3)."""
        return self.smooth.gradient(points)

    def project(self, points: Array, iterations: int = 4) -> tuple[Array, Array]:
        """Move points (N, 3) along the normal to the height at which cells lie.

        Returns:
            points (N, 3) and normals (N, 3).
        """
        points = np.array(points, dtype=float)
        normals = self.normals(points)
        for _ in range(iterations):
            points -= (self.smooth.at(points) - self.height)[:, None] * normals
            normals = self.normals(points)
        return points, normals

    def samples(self, spacing: float = 0.004, seed: int = 0) -> tuple[Array, Array, float]:
        """Even samples of the surface at the cells' height.

        Returns:
            points (M, 3), normals (M, 3) and the area that one sample stands for, square metres. Voxels of a thin
            shell around the level set stand for equal areas (coarea formula: area = volume of shell / thickness).
        """
        step = self.smooth.step
        shell = np.abs(self.smooth.value - self.height) < step
        gradient = np.array(np.gradient(self.smooth.value, step))
        area = float((np.linalg.norm(gradient, axis=0) * shell).sum() * step**3 / (2 * step))
        points = np.argwhere(shell) * step + self.smooth.origin
        points, _ = self.project(points, 2)
        count = max(1, min(len(points), int(area / spacing**2)))
        chosen = np.random.default_rng(seed).choice(len(points), count, replace=False)
        points, normals = self.project(points[chosen])
        return points, normals, area / count
