# SPDX-License-Identifier: Apache-2.0
"""Checking skin files: each read by its content and judged, with the robot's meshes where they are known."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import asdict, dataclass, field
from functools import cache
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from robotskin.errors import RobotskinError
from robotskin.layout.defects import defects
from robotskin.layout.errors import LayoutFileError
from robotskin.layout.formats import read
from robotskin.layout.raw_layout import Defect, RawLayout
from robotskin.layout.surface import DistanceField, distance_field

if TYPE_CHECKING:
    from robotskin.robots import Robot


@dataclass
class Checked:
    """A file and what is wrong with it. cells: found; empty: slots without a cell."""

    file: str
    format: str
    cells: int = 0
    empty: int = 0
    defects: list[Defect] = field(default_factory=list)

    def as_json(self) -> dict[str, Any]:
        """The same as plain values."""
        return asdict(self)


def files_in(paths: Sequence[Path]) -> list[Path]:
    """The files named, and those in and below the folders named, each once, in order."""
    found: dict[Path, None] = {}
    for path in paths:
        entries = sorted(entry for entry in path.rglob("*") if entry.is_file()) if path.is_dir() else [path]
        found.update(dict.fromkeys(entries))
    return list(found)


def check_files(paths: Sequence[Path], robot: str | None = None) -> list[Checked]:
    """Read and judge files; one that is no skin is reported with the one defect that says so.

    Args:
        paths: files or folders.
        robot: name of the robot, or path of its URDF, whose meshes cells are checked against; without it, a layout of
            this project is checked against the robot it names.

    Raises:
        UnknownNameError: a robot asked for that there is not.
    """
    named = _Meshes(robot) if robot else None
    results: list[Checked] = []
    skins: list[tuple[RawLayout, Checked]] = []
    for path in files_in([Path(path) for path in paths]):
        try:
            skin = read(path)
        except LayoutFileError as error:
            defect = Defect("unreadable", error.field, str(error.value)[:60], error.why)
            results.append(Checked(str(path), "unknown", defects=[defect]))
            continue
        checked = Checked(str(path), skin.format, len(skin.cells), skin.empty)
        results.append(checked)
        skins.append((skin, checked))
    for skin, checked in skins:
        # Patches of one skin come in several files of a folder; a neighbour in another of them is no defect.
        folder = Path(skin.file).parent
        elsewhere = frozenset(
            cell.id
            for other, _ in skins
            if other is not skin and other.format == skin.format and Path(other.file).parent == folder
            for cell in other.cells
            if cell.id is not None
        )
        meshes = named
        if meshes is None and skin.robot and skin.format == "robotskin JSON":
            try:
                meshes = _Meshes(skin.urdf or skin.robot)
            except RobotskinError as error:
                why = f"{error}; name its URDF: --robot FILE"
                checked.defects.append(Defect("unknown_robot", "/robot", skin.robot, why))
        sizes = meshes.sizes() if meshes else {}
        field_of = meshes.field_of if meshes else None
        checked.defects += defects(skin, elsewhere=elsewhere, field_of=field_of, link_size=sizes)
    return results


class _Meshes:
    """The meshes of a robot as distance fields, made when asked for."""

    def __init__(self, robot: str) -> None:
        from robotskin import robots

        self.robot: Robot = robots.load(robot)
        self.field_of = cache(self._field_of)

    def _field_of(self, link: str) -> DistanceField | None:
        if link not in self.robot.links_with("collision"):
            return None
        mesh = self.robot.link_mesh(link)
        step = float(np.clip((np.prod(mesh.extents + 0.04) / 5e5) ** (1 / 3), 0.0015, 0.004))
        return distance_field(mesh, step, 0.02)

    def sizes(self) -> dict[str, float]:
        """Diagonal of each link's mesh, metres, its distance from the link's origin included."""
        links = self.robot.links_with("collision")
        return {link: float(np.linalg.norm(np.abs(self.robot.link_mesh(link).bounds).max(axis=0))) for link in links}
