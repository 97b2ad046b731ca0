"""Covering a robot: patches grown on each link, trimmed to the number of cells asked for, wired and measured."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from robotskin._core import firmware
from robotskin.layout.cell import CELL_THICKNESS_M, HEXAGON_SIDE_M, LATTICE_CELL_AREA_M2, PORTS, prism_points
from robotskin.layout.clearance import Clearance
from robotskin.layout.errors import CoveringError
from robotskin.layout.growth import Sheet, grow
from robotskin.layout.layout import Layout, Patch
from robotskin.layout.relax import overlapping_pairs, tangent_poses
from robotskin.layout.surface import DistanceField, LinkSurface
from robotskin.layout.wiring import hop_counts, wire

if TYPE_CHECKING:
    from robotskin.robots import Robot

Array = NDArray[np.float64]
Progress = Callable[[str, int, int], None]
"""Called with what is being done, steps done and steps in all."""

SMALL_PATCH = 8
"""Patches with fewer cells are left out while larger ones suffice: each needs a cable of its own."""


@dataclass(frozen=True)
class Rules:
    """What a place for a cell must satisfy; lengths in metres.

    foam: between the robot and the cell's back. clearance: between a cell and a neighbouring link at any joint
    position. least_foam: what compressed foam leaves between the mesh and a cell's back. overhang_distance: a point of
    the back that stands farther than foam plus this off the mesh hangs over. most_overhang: share of the back that may.
    least_patch: patches with fewer cells are not mounted.
    """

    foam: float = 0.003
    clearance: float = 0.003
    least_foam: float = 0.0005
    overhang_distance: float = 0.006
    most_overhang: float = 0.35
    least_patch: int = 3


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
        return least > self.rules.clearance

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


def grow_link(places: LinkPlaces, seed: int, tries: int) -> Sheet:
    """Sheets grown from several first cells, the best one kept, then the rest of the link filled the same way."""
    random = np.random.default_rng(seed)
    poses = np.zeros((0, 4, 4))
    edges = np.zeros((0, 4), dtype=np.int64)
    unreachable = ~places.coverable
    for _ in range(40):
        open_places = np.flatnonzero(~unreachable)
        if len(open_places) * places.sample_area < places.rules.least_patch * LATTICE_CELL_AREA_M2 * 0.6:
            break
        standing = poses

        def accept(candidates: Array, standing: Array = standing) -> NDArray[np.bool_]:
            good = places.accept(candidates)
            if len(standing) and good.any():
                chosen = np.flatnonzero(good)
                pairs, _ = overlapping_pairs(np.concatenate([standing, candidates[chosen]]), 0.0003)
                mixed = pairs[(pairs.min(axis=1) < len(standing)) & (pairs.max(axis=1) >= len(standing))]
                good[chosen[mixed.max(axis=1) - len(standing)]] = False
            return good

        starts = tangent_poses(
            *(
                array[chosen]
                for chosen in [random.choice(open_places, 24)]
                for array in (places.points, places.normals)
            ),
            random.normal(size=(24, 3)),
        )
        usable = np.flatnonzero(accept(starts))
        best: Sheet | None = None
        best_score = -np.inf
        for start in usable[:tries]:
            sheet = grow(places.surface, accept, starts[start])
            if len(sheet.poses) == 0:
                continue
            # Cells in large connected pieces count, loose ones hardly, and a wide gap costs a little.
            _, label = sheet.components()
            sizes = np.bincount(label)
            score = float(np.sum(sizes**1.2)) - sheet.gaps().sum() / HEXAGON_SIDE_M
            if score > best_score:
                best, best_score = sheet, score
        if best is None:
            # Nothing fits around these samples; a fifth of the open places is given up each time.
            unreachable[random.choice(open_places, max(1, len(open_places) // 5), replace=False)] = True
            continue
        edges = np.concatenate([edges, best.edges + np.array([len(poses), 0, len(poses), 0])])
        poses = np.concatenate([poses, best.poses])
        unreachable |= places.covered(best.poses)
        for pose in best.poses[:1]:
            unreachable |= np.sum((places.points - pose[:3, 3]) ** 2, axis=1) < HEXAGON_SIDE_M**2
    sheet = Sheet(poses, edges)
    if len(poses):
        sheet = sheet.keep(places.accept(poses, exact=True))
    if len(sheet.poses):
        _, label = sheet.components()
        sheet = sheet.keep(np.bincount(label)[label] >= places.rules.least_patch)
    return sheet


def trim_to(patches: list[Sheet], cells: int, least_patch: int) -> list[Sheet]:
    """Take cells away until exactly as many are left as asked for.

    Every patch gives up its share, from its rim, farthest from its middle first, so that what is left is compact and
    connected.
    """
    sizes = np.array([len(patch.poses) for patch in patches])
    quota = np.floor(sizes * cells / sizes.sum()).astype(int)
    quota = np.maximum(quota, np.minimum(sizes, least_patch))
    while quota.sum() != cells:
        change = 1 if quota.sum() < cells else -1
        room = (sizes - quota) / sizes if change > 0 else np.where(quota > least_patch, quota / sizes, -1)
        quota[np.argmax(room)] += change
    result = []
    for patch, wanted in zip(patches, quota, strict=True):
        hops = hop_counts(len(patch.poses), patch.edges)
        middle = int(np.argmin(hops.sum(axis=1)))
        distance = np.linalg.norm(patch.poses[:, :3, 3] - patch.poses[middle, :3, 3], axis=1)
        order = np.lexsort((distance, hops[middle]))
        keep = np.zeros(len(patch.poses), dtype=bool)
        keep[order[:wanted]] = True
        result.append(patch.keep(keep))
    return result


def split(sheet: Sheet) -> list[Sheet]:
    """The connected patches of a sheet."""
    count, label = sheet.components()
    return [sheet.keep(label == number) for number in range(count)]


def cover(
    robot: Robot,
    links: Sequence[str],
    cells: int,
    *,
    rules: Rules | None = None,
    ports_per_section_unit: int = firmware.SECTION_UNIT_PORTS_MAX,
    seed: int = 0,
    tries: int = 3,
    progress: Progress = lambda what, done, steps: None,
) -> tuple[Layout, dict[str, LinkPlaces]]:
    """Cover links of a robot with a number of cells.

    Each link's patches grow over its surface by the hinge rule t = a_p - R a_q, relaxed so that hinge gaps are spread;
    then the patches are trimmed to exactly the number asked for, wired to section units and their cells numbered.

    Args:
        robot: with `.name`, `.model` (Pinocchio), `.link_names` and `.link_mesh(name)`.
        links: names of the links to cover.
        cells: number of cells in all.
        rules: of what a place must satisfy.
        ports_per_section_unit: cables that one section unit takes.
        seed: everything random follows from it; the same seed gives the same layout.
        tries: first cells tried for each patch.
        progress: told about each step.

    Raises:
        CoveringError: an unknown link, one without a mesh, or fewer places than cells.
    """
    rules = rules or Rules()
    if cells < 1:
        raise CoveringError(f"cells: {cells}: at least one")
    fields: dict[str, DistanceField] = {}
    all_places: dict[str, LinkPlaces] = {}
    patches: list[tuple[str, Sheet]] = []
    for number, link in enumerate(links):
        progress(f"covering {link}", number, len(links))
        clearance = Clearance.of(robot, link, fields, seed)
        mesh = robot.link_mesh(link)
        if mesh is None or len(mesh.faces) == 0:
            raise CoveringError(f"link {link!r} of robot {robot.name} has no mesh to cover")
        places = LinkPlaces(LinkSurface.of(mesh, rules.foam + CELL_THICKNESS_M, seed=seed), clearance, rules, seed)
        all_places[link] = places
        sheet = grow_link(places, seed + number, tries)
        patches += [(link, patch) for patch in split(sheet)] if len(sheet.poses) else []
    progress("wiring", len(links), len(links))
    found = sum(len(patch.poses) for _, patch in patches)
    if found < cells:
        raise CoveringError(
            f"cells: {cells}: only {found} fit on {', '.join(links)} of {robot.name}; ask for fewer, name more links, "
            "or allow more overhang"
        )
    link_of = {id(patch): link for link, patch in patches}
    ordered = sorted((patch for _, patch in patches), key=lambda patch: -len(patch.poses))
    while len(ordered[-1].poses) < SMALL_PATCH and sum(len(patch.poses) for patch in ordered[:-1]) >= cells:
        ordered.pop()
    kept = [(link_of[id(patch)], patch) for patch in ordered]
    kept.sort(key=lambda entry: (list(links).index(entry[0]), -len(entry[1].poses)))
    trimmed = trim_to([patch for _, patch in kept], cells, rules.least_patch)
    layout = assemble(
        robot.name,
        tuple(links),
        [(link, patch) for (link, _), patch in zip(kept, trimmed, strict=True)],
        ports_per_section_unit,
    )
    return layout, all_places


def assemble(
    robot: str, links: tuple[str, ...], patches: list[tuple[str, Sheet]], ports_per_section_unit: int
) -> Layout:
    """One layout of patches (link, connected sheet): numbered, wired, each with the middle cell as its root."""
    poses = np.concatenate([patch.poses for _, patch in patches])
    neighbours = np.full((len(poses), PORTS, 2), (-1, 0), dtype=np.int32)
    patch_of = np.zeros(len(poses), dtype=np.int64)
    link_of = np.zeros(len(poses), dtype=np.int32)
    records = []
    start = 0
    seen: dict[str, int] = {}
    for number, (link, patch) in enumerate(patches):
        count = len(patch.poses)
        cell_a, port_a, cell_b, port_b = patch.edges.T
        neighbours[start + cell_a, port_a] = np.stack([start + cell_b, port_b + 1], axis=1)
        neighbours[start + cell_b, port_b] = np.stack([start + cell_a, port_a + 1], axis=1)
        patch_of[start : start + count] = number
        link_of[start : start + count] = links.index(link)
        seen[link] = seen.get(link, 0) + 1
        middle = int(np.argmin(hop_counts(count, patch.edges).sum(axis=1)))
        records.append(Patch(f"{link}_{seen[link]}", link, start + middle))
        start += count
    ids, groups, places = wire(neighbours, patch_of, ports_per_section_unit)
    # Nine decimals are a nanometre: written and read back, the layout is the same to the last bit.
    return Layout(
        robot, links, ids, groups, link_of, np.round(poses, 9) + 0.0, neighbours, patch_of, tuple(records), places
    )
