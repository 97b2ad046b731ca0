# SPDX-License-Identifier: Apache-2.0
"""Covering a robot: patches grown on each link, trimmed to the number of cells asked for, wired and measured."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import replace
from types import MappingProxyType
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from robotskin import firmware
from robotskin.layout.areas import AreasFirst
from robotskin.layout.cables import plan_cables, plan_studs
from robotskin.layout.cell import CELL_THICKNESS_M, PORTS
from robotskin.layout.clearance import Clearance
from robotskin.layout.errors import CoveringError
from robotskin.layout.growth import Sheet
from robotskin.layout.layout import Layout, Patch
from robotskin.layout.patches import grow_link, split
from robotskin.layout.places import Area, LinkPlaces, Rules
from robotskin.layout.separation import clear_of, separate
from robotskin.layout.surface import DistanceField, LinkSurface
from robotskin.layout.trimming import trimmed, worth_a_cable
from robotskin.layout.wiring import hop_counts, wire

if TYPE_CHECKING:
    from robotskin.robots import Robot

Array = NDArray[np.float64]
Progress = Callable[[str, int, int], None]
"""Called with what is being done, steps done and steps in all."""

NO_RULES: Mapping[str, Rules] = MappingProxyType({})
MOST_CELLS = 400
"""As many as a robot is covered with that is asked for no number: what a simulation keeps up with."""


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
    areas: Sequence[Area] = (),
    worn: Layout | None = None,
    least: int = 0,
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
        cells: number of cells in all, those of areas and those worn among them; None: as many as fit, up to MOST_CELLS,
            and no small patch where a large one is.
        rules: of what a place must satisfy.
        link_rules: other rules for some of the links, by name.
        areas: parts of these and other links that get their cells first and exactly so many.
        worn: a skin of further links, such as those of a hand on this arm, that is taken as it is.
        least: cells that each of the links keeps, those of its areas among them, as far as so many fit on it.
        ports_per_section_unit: cables that one section unit takes.
        seed: everything random follows from it; the same seed gives the same layout.
        tries: first cells tried for each patch.
        progress: told about each step.

    Raises:
        CoveringError: fewer places than cells, in all or in one of the areas; an area that is none; fewer cells in all
            than areas and least ask for.
        UnknownNameError: a link that the robot does not have, or one without a mesh.
    """
    rules = rules or Rules()
    every = tuple(dict.fromkeys((*links, *(area.link for area in areas))))
    meshes = {link: robot.link_mesh(link) for link in every}
    needs = needs_of(robot, links, cells, areas, len(worn) if worn else 0, least)
    fields: dict[str, DistanceField] = {}
    all_places: dict[str, LinkPlaces] = {}
    sheets: dict[str, Sheet] = {}
    first = AreasFirst(seed, tries)
    for number, link in enumerate(every):
        progress(f"looking at {link}", number, len(every))
        clearance = Clearance.of(robot, link, fields, seed)
        own = link_rules.get(link, rules)
        surface = LinkSurface.of(meshes[link], own.foam + CELL_THICKNESS_M, seed=seed)
        places = LinkPlaces(surface, clearance, own, seed)
        all_places[link] = places
        first.cover(link, [area for area in areas if area.link == link], places)
    first_cells = sum(area.cells for area in areas) + (len(worn) if worn else 0)
    rest = None if cells is None else cells - first_cells
    for number, link in enumerate(() if rest == 0 else links):
        progress(f"covering {link}", number, len(links))
        sheet = grow_link(all_places[link], seed + number, tries, first.sheets[link].poses)
        sheets[link] = clear_of(sheet, all_places[link], first.sheets)
    progress("keeping links apart", len(links), len(links))
    patches = [
        (link, patch)
        for link, sheet in separate(sheets, {link: all_places[link] for link in sheets}).items()
        for patch in split(sheet)
        if len(patch.poses) >= link_rules.get(link, rules).least_patch
    ]
    found = sum(len(patch.poses) for _, patch in patches)
    if rest is None:
        patches = worth_a_cable(patches, needs)
        most = max(MOST_CELLS - first_cells, sum(needs.values()))
        rest = min(most, sum(len(patch.poses) for _, patch in patches))
        if rest == 0 and not areas:
            raise CoveringError(f"no cell fits on {', '.join(links)} of {robot.name}; allow more overhang")
    elif found < rest:
        beside = f" beside the {sum(area.cells for area in areas)} of areas" if areas else ""
        raise CoveringError(
            f"cells: {cells}: only {found} fit on {', '.join(links)} of {robot.name}{beside}; ask for fewer, name more "
            "links, or allow more overhang"
        )
    kept = trimmed(patches, rest, links, rules.least_patch, needs=needs, keep_small=cells is None) if rest else []
    grown = sorted([*first.patches(), *kept], key=lambda entry: every.index(entry[0]))
    layout = assemble(
        robot.name,
        (*every, *(link for link in worn.links if link not in every)) if worn else every,
        [*grown, *(sheets_of(worn) if worn else [])],
        ports_per_section_unit,
    )
    progress("planning studs and cables", len(links), len(links))
    layout = replace(layout, studs=plan_studs(layout, robot), cables=plan_cables(layout, robot, seed))
    return layout, all_places


def needs_of(
    robot: Robot, links: Sequence[str], cells: int | None, areas: Sequence[Area], worn_cells: int, least: int
) -> dict[str, int]:
    """By link, the cells that it keeps besides those of its areas; refuses what no number of cells can be shared into.

    Raises:
        CoveringError: an area that is none, or fewer cells in all than areas, worn skin and least ask for.
    """
    for area in areas:
        if flaw := area.flaw():
            raise CoveringError(f"area of {area.link}: {flaw}")
    if cells is not None and cells < 1:
        raise CoveringError(f"cells: {cells}: at least one")
    first = sum(area.cells for area in areas) + worn_cells
    named = "areas and worn skin" if worn_cells else "areas"
    if cells is not None and cells < first:
        raise CoveringError(
            f"cells: {cells}: {named} alone ask for {first}; ask for so many in all, or for fewer there"
        )
    if least < 0 or (least and not links):
        why = "a number from 0 on" if least < 0 else f"no link of {robot.name} is covered but by areas, which are exact"
        raise CoveringError(f"least: {least}: {why}")
    in_areas = {link: sum(area.cells for area in areas if area.link == link) for link in links}
    needs = {link: max(0, least - taken) for link, taken in in_areas.items()}
    if cells is not None and cells < first + sum(needs.values()):
        asked = first + sum(needs.values())
        beside = f" and {first} of {named}" if first else ""
        raise CoveringError(
            f"cells: {cells}: at least {least} on each of {len(needs)} links of {robot.name}{beside} makes {asked}; "
            f"ask for {asked} cells or more, name fewer links, or ask for less on each"
        )
    return needs


def sheets_of(layout: Layout) -> list[tuple[str, Sheet]]:
    """The patches of a finished skin with their links, as `assemble` takes them."""
    found = []
    for number, patch in enumerate(layout.patches):
        cells = np.flatnonzero(layout.patch == number)
        place = {int(cell): index for index, cell in enumerate(cells)}
        edges = [
            (place[int(cell)], port, place[int(other)], other_port - 1)
            for cell in cells
            for port, (other, other_port) in enumerate(layout.neighbours[cell])
            if other > cell
        ]
        found.append((patch.link, Sheet(layout.link_from_cell[cells], np.array(edges, dtype=np.int64).reshape(-1, 4))))
    return found


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
