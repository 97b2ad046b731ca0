# SPDX-License-Identifier: Apache-2.0
"""Which surfaces under cells lie beneath them: MuJoCo takes a mesh's convex hull, which may stick out of the skin."""

import mujoco
import numpy as np
import trimesh
from numpy.typing import NDArray

from robotskin.layout import Layout
from robotskin.layout.cell import CELL_THICKNESS_M, FLAT_NORMALS, HEXAGON_SIDE_M

SAMPLES = 3000
TOLERANCE_M = 0.001
"""How far a hull may reach into a cell from behind."""


def hulls_that_stick_out(model: mujoco.MjModel, layout: Layout, bit: int) -> list[int]:
    """Geoms of collision type `bit` of which some point lies above the back of a cell of their link."""
    found = []
    for geom in np.flatnonzero(model.geom_contype == bit):
        name = model.body(int(model.geom_bodyid[geom])).name
        if name not in layout.links:
            continue
        cells = layout.link_from_cell[layout.link == layout.links.index(name)]
        if len(cells) and _above_back(_surface(model, int(geom)), cells):
            found.append(int(geom))
    return found


def _above_back(points: NDArray[np.float64], cells: NDArray[np.float64]) -> bool:
    across = HEXAGON_SIDE_M * np.sqrt(0.75)
    for pose in cells:
        local = (points - pose[:3, 3]) @ pose[:3, :3]
        high = local[:, 2] > TOLERANCE_M - CELL_THICKNESS_M
        if high.any() and (np.abs(local[high, :2] @ FLAT_NORMALS.T).max(axis=1) < across).any():
            return True
    return False


def _surface(model: mujoco.MjModel, geom: int) -> NDArray[np.float64]:
    """Points (M, 3) of the surface that MuJoCo collides, in the frame of its body."""
    size = model.geom_size[geom]
    kind = model.geom_type[geom]
    if kind == mujoco.mjtGeom.mjGEOM_MESH:
        mesh = int(model.geom_dataid[geom])
        start = model.mesh_vertadr[mesh]
        hull = trimesh.convex.convex_hull(model.mesh_vert[start : start + model.mesh_vertnum[mesh]])
    elif kind == mujoco.mjtGeom.mjGEOM_BOX:
        hull = trimesh.creation.box(2 * size)
    elif kind == mujoco.mjtGeom.mjGEOM_SPHERE:
        hull = trimesh.creation.icosphere(radius=size[0])
    elif kind == mujoco.mjtGeom.mjGEOM_CAPSULE:
        hull = trimesh.creation.capsule(height=2 * size[1], radius=size[0])
        hull.apply_translation([0, 0, -hull.centroid[2]])
    else:
        hull = trimesh.creation.cylinder(radius=size[0], height=2 * size[1])
    points = np.concatenate([hull.vertices, trimesh.sample.sample_surface(hull, SAMPLES, seed=0)[0]])
    rotation = np.zeros(9)
    mujoco.mju_quat2Mat(rotation, model.geom_quat[geom])
    return points @ rotation.reshape(3, 3).T + model.geom_pos[geom]
