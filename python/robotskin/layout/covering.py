"""Covering a robot: patches grown on each link, trimmed to the number of cells asked for, wired and measured."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import replace
from types import MappingProxyType
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from robotskin._core import firmware
from robotskin.layout.cables import plan_cables, plan_studs
from robotskin.layout.cell import CELL_THICKNESS_M, HEXAGON_SIDE_M, LATTICE_CELL_AREA_M2, PORTS
from robotskin.layout.clearance import Clearance
from robotskin.layout.errors import CoveringError
from robotskin.layout.growth import Sheet, grow
from robotskin.layout.layout import Layout, Patch
from robotskin.layout.places import LinkPlaces, Rules
from robotskin.layout.relax import overlapping_pairs, tangent_poses
from robotskin.layout.separation import separate
from robotskin.layout.surface import DistanceField, LinkSurface
from robotskin.layout.wiring import hop_counts, wire

if TYPE_CHECKING:
    from robotskin.robots import Robot

Array = NDArray[np.float64]
Progress = Callable[[str, int, int], None]
"""Called with what is being done, steps done and steps in all."""

NO_RULES: Mapping[str, Rules] = MappingProxyType({})
MOST_CELLS = 400
"""As many as a robot is covered with that is asked for no number: what a simulation keeps up with."""
SMALL_PATCH = 8
"""Patches with fewer cells are left out while larger ones suffice: each needs a cable of its own."""


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

        drawn = random.choice(open_places, 24)
        starts = tangent_poses(places.points[drawn], places.normals[drawn], random.normal(size=(24, 3)))
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


def _worth_a_cable(patches: list[tuple[str, Sheet]]) -> list[tuple[str, Sheet]]:
    """Patches that are not small, and of each link that has none of those its largest."""
    largest: dict[str, int] = {}
    for link, patch in patches:
        largest[link] = max(largest.get(link, 0), len(patch.poses))
    return [(link, patch) for link, patch in patches if len(patch.poses) >= min(SMALL_PATCH, largest[link])]


def split(sheet: Sheet) -> list[Sheet]:
    """The connected patches of a sheet."""
    if len(sheet.poses) == 0:
        return []
    count, label = sheet.components()
    return [sheet.keep(label == number) for number in range(count)]


def moving_links(robot: Robot) -> tuple[str, ...]:
    """The links that move and have a surface: those that can wear skin and feel it move."""
    joints = robot.core.link_joints
    return tuple(link for link in robot.links_with("collision") if joints[robot.link_index(link)] >= 0)


def cover(
    robot: Robot,
    links: Sequence[str],
    cells: int | None,
    *,
    rules: Rules | None = None,
    link_rules: Mapping[str, Rules] = NO_RULES,
    ports_per_section_unit: int = firmware.SECTION_UNIT_PORTS_MAX,
    seed: int = 0,
    tries: int = 3,
    progress: Progress = lambda what, done, steps: None,
) -> tuple[Layout, dict[str, LinkPlaces]]:
    """Cover links of a robot with a number of cells.

    Each link's patches grow over its surface by the hinge rule t = a_p - R a_q, relaxed so that hinge gaps are spread;
    then the patches are trimmed to exactly the number asked for, wired to section units and their cells numbered.

    Args:
        robot: whose collision meshes are covered.
        links: names of the links to cover.
        cells: number of cells in all; None: as many as fit, up to MOST_CELLS, and no small patch where a large one is.
        rules: of what a place must satisfy.
        link_rules: other rules for some of the links, by name.
        ports_per_section_unit: cables that one section unit takes.
        seed: everything random follows from it; the same seed gives the same layout.
        tries: first cells tried for each patch.
        progress: told about each step.

    Raises:
        CoveringError: fewer places than cells.
        UnknownNameError: a link that the robot does not have, or one without a mesh.
    """
    rules = rules or Rules()
    wanted = cells
    if cells is not None and cells < 1:
        raise CoveringError(f"cells: {cells}: at least one")
    fields: dict[str, DistanceField] = {}
    all_places: dict[str, LinkPlaces] = {}
    sheets: dict[str, Sheet] = {}
    for number, link in enumerate(links):
        progress(f"covering {link}", number, len(links))
        clearance = Clearance.of(robot, link, fields, seed)
        own = link_rules.get(link, rules)
        surface = LinkSurface.of(robot.link_mesh(link), own.foam + CELL_THICKNESS_M, seed=seed)
        places = LinkPlaces(surface, clearance, own, seed)
        all_places[link] = places
        sheets[link] = grow_link(places, seed + number, tries)
    progress("keeping links apart", len(links), len(links))
    patches = [
        (link, patch)
        for link, sheet in separate(sheets, all_places).items()
        for patch in split(sheet)
        if len(patch.poses) >= link_rules.get(link, rules).least_patch
    ]
    found = sum(len(patch.poses) for _, patch in patches)
    if cells is None:
        patches = _worth_a_cable(patches)
        cells = min(MOST_CELLS, sum(len(patch.poses) for _, patch in patches))
        if cells == 0:
            raise CoveringError(f"no cell fits on {', '.join(links)} of {robot.name}; allow more overhang")
    elif found < cells:
        raise CoveringError(
            f"cells: {cells}: only {found} fit on {', '.join(links)} of {robot.name}; ask for fewer, name more links, "
            "or allow more overhang"
        )
    link_of = {id(patch): link for link, patch in patches}
    ordered = sorted((patch for _, patch in patches), key=lambda patch: -len(patch.poses))
    while (
        wanted is not None
        and len(ordered[-1].poses) < SMALL_PATCH
        and sum(len(patch.poses) for patch in ordered[:-1]) >= cells
    ):
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
    progress("planning studs and cables", len(links), len(links))
    layout = replace(layout, studs=plan_studs(layout, robot), cables=plan_cables(layout, robot, seed))
    return layout, all_places


def assemble(
    robot: str, links: tuple[str, ...], patches: list[tuple[str, Sheet]], ports_per_section_unit: int
) -> Layout:
    """One layout of patches (link, connected sheet): numbered, wired, each with the middle cell as its root."""
    poses = np.concatenate([patch.poses for _, patch in patches])
    neighbours = np.full((len(poses), PORTS, 2), (-1, 0), dtype=np.int32)
    patch_of = np.zeros(len(poses), dtype=np.int32)
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
    ids, groups, places = wire(neighbours, patch_of.astype(np.int64), ports_per_section_unit)
    # Nine decimals are a nanometre: written and read back, the layout is the same to the last bit.
    return Layout(
        robot, links, ids, groups, link_of, np.round(poses, 9) + 0.0, neighbours, patch_of, tuple(records), places
    )
