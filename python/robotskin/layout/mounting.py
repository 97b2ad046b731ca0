# SPDX-License-Identifier: Apache-2.0
"""Mounting a skin that was made for another robot: its rigid patches, as they are, on a link of this one."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray
from scipy.sparse import coo_matrix
from scipy.sparse.csgraph import connected_components

from robotskin import firmware
from robotskin.layout.cell import CELL_THICKNESS_M
from robotskin.layout.clearance import Clearance
from robotskin.layout.errors import LayoutError, LayoutFileError
from robotskin.layout.formats import read
from robotskin.layout.json_file import parse
from robotskin.layout.layout import Layout, Patch, SectionUnitPort
from robotskin.layout.places import LinkPlaces, Rules
from robotskin.layout.raw_layout import RawCell, RawLayout
from robotskin.layout.raw_neighbours import neighbours_of
from robotskin.layout.relax import overlapping_pairs, tangent_poses
from robotskin.layout.surface import LinkSurface
from robotskin.layout.wiring import wire

if TYPE_CHECKING:
    from robotskin.robots import Robot

Array = NDArray[np.float64]

YAWS = 12
"""Turns about the normal that are tried at each place."""
PLACES = 250


@dataclass
class RigidPatch:
    """A patch as its file has it: cells, and their poses (N, 4, 4) in the frame of the root cell."""

    name: str
    cells: list[RawCell]
    root: int
    root_from_cell: Array


def read_for(robot: Robot, path: str | Path, link: str | None = None, *, seed: int = 0) -> Layout:
    """A layout for a robot from a file or folder, whatever its format.

    Args:
        robot: that is to wear the skin.
        path: a layout of this project made for this robot, or a TUM file, or a folder of TUM files.
        link: on which to mount a skin that was made for another robot; not needed for this robot's own layout.
        seed: of the search for a place.

    Raises:
        LayoutFileError: nothing there that can be read as a skin, or a layout made for links that the robot lacks.
        LayoutError: a foreign skin and no link to mount it on, or no place for it.
        UnknownNameError: a link that the robot does not have.
    """
    path = Path(path)
    if path.is_file() and path.name.endswith((".json", ".json.gz")):
        document = parse(path)
        if isinstance(document, dict) and document.get("format") == "robotskin-layout":
            layout = Layout.load(path)
            foreign = [name for name in layout.links if name not in robot.link_names]
            if foreign:
                why = f"{robot.name} has no such link; it has {', '.join(robot.link_names)}"
                raise LayoutFileError(path, "links", foreign[0], why)
            return layout
    if link is None:
        if path.is_file():
            read(path)  # a file that is no skin is named as one
        raise LayoutError(f"{path}: a skin made for another robot; name the link of {robot.name} to mount it on")
    return mount(path, robot, link, seed=seed)


def skin_files(path: Path) -> list[Path]:
    """The file itself, or the files in a folder, by name."""
    if path.is_dir():
        return sorted(entry for entry in path.iterdir() if entry.is_file() and not entry.name.startswith("."))
    return [path]


def rigid_patches(skins: list[RawLayout]) -> list[RigidPatch]:
    """Patches of cells with full poses and neighbours; other formats have none."""
    patches = []
    for skin in skins:
        numbers = dict.fromkeys(cell.patch for cell in skin.cells if cell.rotation is not None and cell.neighbours)
        for number in numbers:
            cells = [cell for cell in skin.cells if cell.patch == number]
            ids = [cell.id for cell in cells]
            root_id = skin.root_of_patch.get(number)
            root = ids.index(root_id) if root_id in ids else 0
            poses = np.tile(np.eye(4), (len(cells), 1, 1))
            for index, cell in enumerate(cells):
                poses[index, :3, :3], poses[index, :3, 3] = cell.rotation, cell.position
            if not np.isfinite(poses).all():
                raise LayoutFileError(skin.file, f"patch {number}", "not finite", "poses must be finite numbers")
            # Rotations of files are rounded; the nearest rotation is what was meant.
            left, _, right = np.linalg.svd(poses[:, :3, :3])
            poses[:, :3, :3] = left @ right
            patches.append(
                RigidPatch(f"{Path(skin.file).stem}_{number}", cells, root, np.linalg.inv(poses[root]) @ poses)
            )
    return patches


def mount(path: str | Path, robot: Robot, link: str, *, rules: Rules | None = None, seed: int = 0) -> Layout:
    """Mount the patches of TUM files on a link, keeping the poses inside each patch and the cells' neighbours.

    Each patch is rigid. Its root cell lies tangent on the surface, lifted just so far that no cell of the patch is
    inside the mesh; of the places and turns tried, the one where the patch stands off least is taken.
    Neighbours are kept where both cells list each other; a port that faces the interface box (id 16383) becomes a
    section-unit port.

    Args:
        path: a file or a folder of files.
        robot: the one that is to wear the skin.
        link: its name.
        rules: of clearance and foam.
        seed: of the places tried.

    Raises:
        LayoutFileError: no file there, or none with cells that have poses and neighbours.
        LayoutError: no place on the link where the patches fit.
    """
    path = Path(path)
    files = skin_files(path)
    skins, problems = [], []
    for file in files:
        try:
            skins.append(read(file))
        except LayoutFileError as error:
            problems.append(error)
    # A folder may hold the same kind of skin in two dialects; patches on one robot are of the most common one.
    formats = [skin.format for skin in skins]
    common = max(dict.fromkeys(formats), key=formats.count) if formats else ""
    patches = rigid_patches([skin for skin in skins if skin.format == common])
    if not patches:
        why = "no cells with poses and neighbours" + (f"; {problems[0]}" if problems else "")
        raise LayoutFileError(path, "file", path.name, why)
    rules = rules or Rules()
    surface = LinkSurface.of(robot.link_mesh(link), rules.foam + CELL_THICKNESS_M, seed=seed)
    places = LinkPlaces(surface, Clearance.of(robot, link, {}, seed), rules, seed)
    standing = np.zeros((0, 4, 4))
    for patch in sorted(patches, key=lambda patch: -len(patch.cells)):
        poses = find_place(patch, places, standing, seed)
        patch.root_from_cell = poses
        standing = np.concatenate([standing, poses])
    return _layout(patches, robot.name, link, str(path))


def find_place(patch: RigidPatch, places: LinkPlaces, standing: Array, seed: int) -> Array:
    """(N, 4, 4) link_from_cell of a patch where it stands off the mesh least, clear of neighbours and of other cells.

    Raises:
        LayoutError: nowhere.
    """
    random = np.random.default_rng(seed)
    open_places = np.flatnonzero(places.coverable)
    chosen = random.choice(open_places, min(PLACES, len(open_places)), replace=False)
    normals = places.normals[chosen]
    first = tangent_poses(places.points[chosen], normals, np.eye(3)[np.argmin(np.abs(normals), axis=1)])
    angles = np.arange(YAWS) * 2 * np.pi / YAWS
    turns = np.tile(np.eye(4), (YAWS, 1, 1))
    turns[:, 0, 0], turns[:, 0, 1] = np.cos(angles), -np.sin(angles)
    turns[:, 1, 0], turns[:, 1, 1] = np.sin(angles), np.cos(angles)
    count = len(patch.cells)
    trials = (first[:, None, None] @ turns[:, None] @ patch.root_from_cell).reshape(-1, count, 4, 4)
    least = places.least_foam(trials.reshape(-1, 4, 4)).reshape(-1, count).min(axis=1)
    lift = np.maximum(0.0, places.rules.least_foam - least)
    trials[:, :, :3, 3] += (lift[:, None] * np.repeat(normals, YAWS, axis=0))[:, None]
    stand_off = places.surface.raw.at(trials[:, :, :3, 3]).max(axis=1)
    for poses in trials[np.argsort(stand_off, kind="stable")]:
        if places.least_foam(poses).min() < 0 or places.room(poses, exact=False).min() <= places.rules.clearance:
            continue
        if len(standing):
            pairs, _ = overlapping_pairs(np.concatenate([standing, poses]))
            if np.any((pairs.min(axis=1) < len(standing)) & (pairs.max(axis=1) >= len(standing))):
                continue
        return poses
    raise LayoutError(f"patch {patch.name} of {len(patch.cells)} cells: no place on the link where it fits")


def _layout(patches: list[RigidPatch], robot: str, link: str, source: str) -> Layout:
    """Number, connect and wire mounted patches (their poses now in the link frame)."""
    cells = [cell for patch in patches for cell in patch.cells]
    count = len(cells)
    neighbours, box_ports = neighbours_of(cells)
    number = np.concatenate([np.full(len(patch.cells), index) for index, patch in enumerate(patches)])
    start = np.cumsum([0, *(len(patch.cells) for patch in patches)])
    records = [Patch(patch.name, link, int(start[i] + patch.root)) for i, patch in enumerate(patches)]
    here, plugged = np.nonzero(neighbours[:, :, 0] >= 0)
    graph = coo_matrix((np.ones(len(here)), (here, neighbours[here, plugged, 0])), shape=(count, count))
    network = connected_components(graph, directed=False)[1].astype(np.int64)
    ids, groups, wired = wire(neighbours, network)
    own_ids = np.array([cell.id or 0 for cell in cells])
    if len(np.unique(own_ids)) == count and own_ids.min() >= firmware.ID_FIRST and own_ids.max() <= firmware.ID_LAST:
        ids = own_ids.astype(np.uint16)
    places: list[SectionUnitPort] = []
    for component in range(int(network.max()) + 1):
        stated = [index for index in box_ports if network[index] == component]
        if stated:
            places += [SectionUnitPort(1, 0, index, box_ports[index]) for index in stated]
        else:
            places += [place for place in wired if network[place.cell] == component]
    places = [SectionUnitPort(1, port, place.cell, place.cell_port) for port, place in enumerate(places, start=1)]
    poses = np.round(np.concatenate([patch.root_from_cell for patch in patches]), 9) + 0.0
    return Layout(
        robot,
        (link,),
        ids,
        np.ones_like(groups),
        np.zeros(count, dtype=np.int32),
        poses,
        neighbours,
        number,
        tuple(records),
        tuple(places),
        source=source,
    )
