# SPDX-License-Identifier: Apache-2.0
"""A layout of the taxels of iCub text files on links of a robot: places only, no cables, a group a file."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray
from scipy.spatial import cKDTree

from robotskin.layout.errors import LayoutError, LayoutFileError
from robotskin.layout.formats import icub, read
from robotskin.layout.layout import Layout, Patch
from robotskin.layout.raw_layout import RawLayout

if TYPE_CHECKING:
    from robotskin.robots import Robot

Array = NDArray[np.float64]

FRAMES = ("{}_dh_frame", "{}_skin_frame", "{}")
"""Of the link that a file names, the frame of the robot's model in which its taxels are most likely given."""
PLANE = 10
"""Taxels of which a normal is made where the file gives none."""


@dataclass(frozen=True)
class Taxels:
    """One file's part of a layout. link: on which it is; cells: how many; made_normals: the file gives none that can be
    used; off_mesh_m: median distance of the taxels to the surface of the robot's links, NaN where it has no surface."""

    file: str
    group: int
    link: str
    cells: int
    made_normals: bool
    off_mesh_m: float


def taxel_layout(
    files: Sequence[str | Path],
    robot: Robot,
    link: str | None = None,
    link_from_skin: Array | None = None,
) -> tuple[Layout, list[Taxels]]:
    """The layout, and what was found of each file.

    A cell's id is the number of its row plus one, its group the number of its file from 1, its patch its triangle.

    Args:
        files: iCub taxel files. robot: that wears them.
        link: on which all are; by default the one that each file names.
        link_from_skin: (4, 4) metres, how the files' frame lies in the link's; by default they are the same.

    Raises:
        LayoutFileError: no taxel file, or one without taxels. LayoutError: a link that the robot does not have.
    """
    skins = [_taxels_of(Path(file)) for file in files]
    links: list[str] = []
    ids: list[int] = []
    groups: list[int] = []
    on: list[int] = []
    patch: list[int] = []
    poses: list[Array] = []
    patches: list[Patch] = []
    found: list[Taxels] = []
    for group, skin in enumerate(skins, start=1):
        name = _link_of(skin, robot, link)
        if name not in links:
            links.append(name)
        places, normals, made = outward(skin)
        at = _poses(places, normals)
        if link_from_skin is not None:
            at = link_from_skin @ at
        first = len(ids)
        triangles = np.array([cell.patch for cell in skin.cells])
        for triangle in np.unique(triangles):
            root = first + int(np.argmax(triangles == triangle))
            patch.extend([len(patches)] * int((triangles == triangle).sum()))
            patches.append(Patch(f"{skin.cells[0].link or name}_{triangle}", name, root))
        ids += [int(cell.where.split()[1]) + 1 for cell in skin.cells]
        groups += [group] * len(skin.cells)
        on += [links.index(name)] * len(skin.cells)
        poses.append(at)
        found.append(Taxels(skin.file, group, name, len(skin.cells), made, _off_mesh(robot, name, at[:, :3, 3])))
    count = len(groups)
    neighbours = np.zeros((count, 4, 2), np.int32)
    neighbours[:, :, 0] = -1
    layout = Layout(
        robot.name,
        tuple(links),
        np.array(ids, np.uint16),
        np.array(groups, np.uint16),
        np.array(on, np.int32),
        np.round(np.concatenate(poses), 9).astype(np.float64),
        neighbours,
        np.array(patch, np.int32),
        tuple(patches),
        source=", ".join(Path(file).name for file in files),
    )
    return layout, found


def outward(skin: RawLayout) -> tuple[Array, Array, bool]:
    """(N, 3) places, (N, 3) unit normals, and whether these had to be made of the places.

    Many files give one placeholder for all, or zeros. Then a taxel's normal is that of the plane through those beside
    it, away from the middle of all.
    """
    places, normals = skin.positions(), skin.normals()
    length = np.linalg.norm(normals, axis=1)
    if length.min() > 0.5 and len(np.unique(np.round(normals, 6), axis=0)) > 1:
        return places, normals / length[:, None], False
    if len(places) < 3:
        raise LayoutFileError(skin.file, "normals", f"{len(places)} taxels", "no normals, and too few to make some of")
    _, beside = cKDTree(places).query(places, k=min(PLANE, len(places)))
    made = np.empty_like(places)
    middle = places.mean(axis=0)
    for cell, near in enumerate(beside):
        away = places[near] - places[near].mean(axis=0)
        normal = np.linalg.svd(away)[2][2]
        made[cell] = normal if normal @ (places[cell] - middle) >= 0 else -normal
    return places, made, True


def _taxels_of(file: Path) -> RawLayout:
    skin = read(file)
    if skin.format != icub.FORMAT:
        raise LayoutFileError(file, "format", skin.format, "a taxel file of the iCub is expected")
    if not skin.cells:
        raise LayoutFileError(file, "rows", "0 taxels", "every row is all zero")
    return skin


def _link_of(skin: RawLayout, robot: Robot, link: str | None) -> str:
    body = skin.cells[0].link
    wanted = [link] if link is not None else [frame.format(body) for frame in FRAMES]
    for name in wanted:
        if name in robot.link_names:
            return name
    raise LayoutError(
        f"{skin.file}: link {wanted[-1]!r}: {robot.name} has no such link; give --link, one of "
        f"{', '.join(robot.link_names)}"
    )


def _poses(places: Array, normals: Array) -> Array:
    """(N, 4, 4) with z along the normals."""
    helper = np.eye(3)[np.argmin(np.abs(normals), axis=1)]
    x = np.cross(helper, normals)
    x /= np.linalg.norm(x, axis=1)[:, None]
    poses = np.tile(np.eye(4), (len(places), 1, 1))
    poses[:, :3, 0], poses[:, :3, 1], poses[:, :3, 2], poses[:, :3, 3] = x, np.cross(normals, x), normals, places
    return poses


def _off_mesh(robot: Robot, link: str, points: Array) -> float:
    """Median metres from points in a link's frame to the nearest surface of the robot, in its zero posture."""
    import trimesh

    base_from_link = dict(zip(robot.link_names, robot.base_from_link(np.zeros(robot.joint_count)), strict=True))
    at = points @ base_from_link[link][:3, :3].T + base_from_link[link][:3, 3]
    nearest = np.full(len(at), np.inf)
    for name in robot.links_with("visual"):
        mesh = robot.link_mesh(name).copy()
        mesh.apply_transform(base_from_link[name])
        low, high = mesh.bounds
        if np.linalg.norm(np.maximum(np.maximum(low - at, at - high), 0), axis=1).min() < min(nearest.max(), 0.2):
            nearest = np.minimum(nearest, trimesh.proximity.closest_point(mesh, at)[1])
    return float(np.median(nearest)) if np.isfinite(nearest).any() else float("nan")
