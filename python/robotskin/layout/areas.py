# SPDX-License-Identifier: Apache-2.0
"""Areas of links that get their cells first: a palm, a pad, a finger's tip."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from robotskin.layout.errors import CoveringError
from robotskin.layout.growth import Sheet, grow
from robotskin.layout.patches import grow_link, split
from robotskin.layout.places import Area, LinkPlaces
from robotskin.layout.relax import overlapping_pairs, tangent_poses
from robotskin.layout.separation import clear_of
from robotskin.layout.trimming import trim_to

Array = NDArray[np.float64]


class AreasFirst:
    """The cells of areas, link by link."""

    def __init__(self, seed: int, tries: int) -> None:
        self.seed, self.tries = seed, tries
        self.sheets: dict[str, Sheet] = {}

    def cover(self, link: str, areas: Sequence[Area], places: LinkPlaces) -> None:
        """Fill the areas of a link, in their order. Raises CoveringError if one takes fewer cells than it shall."""
        joined = Sheet(np.zeros((0, 4, 4)), np.zeros((0, 4), dtype=np.int64))
        for area in areas:
            own = LinkPlaces(places.surface, places.clearance, area.rules_on(places.rules), self.seed)
            sheet = grow_area(own, area, self.seed, self.tries, joined.poses)
            # Areas with rules of their own may meet, as the pads of a hand do.
            if area.rules is None and len(clear_of(sheet, own, self.sheets).poses) < len(sheet.poses):
                sheet = grow_area(own, area, self.seed, self.tries, joined.poses, self.sheets)
            if len(sheet.poses) < area.cells:
                raise CoveringError(
                    f"area of {link} that faces {area.facing}: {area.cells} cells asked for, {len(sheet.poses)} fit; "
                    "ask for fewer, or allow a larger angle or more overhang"
                )
            shift = np.array([len(joined.poses), 0, len(joined.poses), 0])
            joined = Sheet(
                np.concatenate([joined.poses, sheet.poses]), np.concatenate([joined.edges, sheet.edges + shift])
            )
        self.sheets[link] = joined

    def patches(self) -> list[tuple[str, Sheet]]:
        """All connected patches, with their links."""
        return [(link, patch) for link, sheet in self.sheets.items() for patch in split(sheet)]


@dataclass(frozen=True)
class Plane:
    """The plane of a cell's face: on it the lattice lies without tension, and its first cell stays where it is."""

    point: Array
    normal: Array

    @classmethod
    def under(cls, pose: Array) -> Plane:
        """That of a cell's pose (4, 4)."""
        return cls(pose[:3, 3], pose[:3, 2])

    def project(self, points: Array, iterations: int = 4) -> tuple[Array, Array]:
        """Points (N, 3) on the plane, and its normal for each."""
        points = points - ((points - self.point) @ self.normal)[:, None] * self.normal
        return points, np.tile(self.normal, (len(points), 1))


def grow_area(
    places: LinkPlaces, area: Area, seed: int, tries: int, taken: Array, others: dict[str, Sheet] | None = None
) -> Sheet:
    """The cells of an area, as many as it asks for if they fit: those nearest to its first cell, or largest patches.

    taken: (K, 4, 4) cells that the link has already. others: cells of other links, by name, that none may meet.
    """
    if area.at_m is None:
        grown = clear_of(grow_link(places, seed, tries, taken), places, others or {})
        patches = sorted(split(grown), key=lambda patch: -len(patch.poses))
        kept: list[Sheet] = []
        while patches and sum(len(patch.poses) for patch in kept) < area.cells:
            kept.append(patches.pop(0))
        if sum(len(patch.poses) for patch in kept) > area.cells:
            kept = trim_to(kept, area.cells, 1)
        return _joined(kept)

    def accept(candidates: Array) -> NDArray[np.bool_]:
        good = places.accept(candidates, exact=True)
        for index in np.flatnonzero(good) if len(taken) else ():
            pairs, _ = overlapping_pairs(np.concatenate([taken, candidates[[index]]]), 0.0003)
            good[index] = not (pairs == len(taken)).any()
        return good

    turns = np.arange(12) * np.pi / 18  # a hexagon looks the same after 60 degrees, its four ports after 180
    points, normals = places.surface.project(np.tile(area.at_m, (len(turns), 1)))
    hints = np.stack([np.cos(turns), np.sin(turns), np.full(len(turns), 0.123)], axis=1)
    starts = tangent_poses(points, normals, hints)
    best = Sheet(np.zeros((0, 4, 4)), np.zeros((0, 4), dtype=np.int64))
    least = np.inf
    for start in starts[accept(starts)]:
        sheet = Sheet(start[None], best.edges[:0]) if area.cells == 1 else grow(Plane.under(start), accept, start)
        if len(sheet.poses):
            count, label = sheet.components()
            middle = int(np.argmin(np.linalg.norm(sheet.poses[:, :3, 3] - start[:3, 3], axis=1)))
            sheet = sheet.keep(label == label[middle]) if count > 1 else sheet
            near = np.argsort(np.linalg.norm(sheet.poses[:, :3, 3] - start[:3, 3], axis=1), kind="stable")
            sheet = sheet.keep(np.isin(np.arange(len(near)), near[: area.cells]))
        sheet = clear_of(sheet, places, others or {})
        overhang = float(places.overhang(sheet.poses).sum())
        if (len(sheet.poses), -overhang) > (len(best.poses), -least):
            best, least = sheet, overhang
    return best


def _joined(patches: Sequence[Sheet]) -> Sheet:
    poses, edges = [np.zeros((0, 4, 4))], [np.zeros((0, 4), dtype=np.int64)]
    count = 0
    for patch in patches:
        poses.append(patch.poses)
        edges.append(patch.edges + np.array([count, 0, count, 0]))
        count += len(patch.poses)
    return Sheet(np.concatenate(poses), np.concatenate(edges))
