# SPDX-License-Identifier: Apache-2.0
"""Limits of contact by body region, in the manner of ISO/TS 15066, read from a user's file.

No number is ours. The file that comes with the project, `body_limits.toml`, is empty; those who add a number name its
source.
What the guard does with them stands in `core/robot/body_limits.hpp`.
"""

from __future__ import annotations

import math
import tomllib
from collections.abc import Iterable
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from robotskin import cycle as core
from robotskin.errors import RobotskinError, UnknownNameError
from robotskin.layout import Layout

LIMITS = (
    "quasi_static_force_n",
    "transient_force_n",
    "quasi_static_pressure_n_cm2",
    "transient_pressure_n_cm2",
)
PARTS = ("links", "patches", "cells")
FIELDS = ("name", *PARTS, *LIMITS, "transient_s")
"""What a region may state."""

EMPTY_FILE = Path(__file__).with_suffix(".toml")
"""The file to copy."""


class BodyLimitsError(RobotskinError):
    """A file of limits that cannot be used; the message names file, region, field, value and what would be valid."""


@dataclass(frozen=True)
class Region:
    """A region of the body, what of the robot may meet it, and the limits that the file states; see `FIELDS`."""

    name: str
    links: tuple[str, ...] = ()
    patches: tuple[str, ...] = ()
    cells: tuple[tuple[int, int], ...] = ()
    """(section unit, id) of single cells."""
    quasi_static_force_n: float = math.inf
    transient_force_n: float = math.inf
    quasi_static_pressure_n_cm2: float = math.inf
    transient_pressure_n_cm2: float = math.inf
    transient_s: float = 0.0


@dataclass(frozen=True)
class BodyLimits:
    """All regions of a file. A contact without a limit of its own kind has that of the other kind."""

    file: str
    source: str
    regions: tuple[Region, ...]

    @classmethod
    def load(cls, path: str | Path) -> BodyLimits:
        """Read a file. Raises FileNotFoundError or BodyLimitsError."""
        try:
            values = tomllib.loads(Path(path).read_text(encoding="utf-8"))
        except (tomllib.TOMLDecodeError, UnicodeDecodeError) as error:
            raise BodyLimitsError(f"{path}: {error}") from error
        return cls(str(path), *_checked(values, str(path)))

    def for_skin(self, layout: Layout, silent_n: float) -> core.BodyLimits:
        """The limits as the guard takes them.

        Args:
            layout: the skin that measures.
            silent_n: a cell that feels no more is not touched.

        Raises UnknownNameError for a link without cells or a patch that there is not, BodyLimitsError for a cell.
        """
        regions = [
            core.BodyRegion(
                region.name,
                self._cells(region, layout),
                core.ContactLimit(region.transient_force_n, region.quasi_static_force_n),
                core.ContactLimit(region.transient_pressure_n_cm2, region.quasi_static_pressure_n_cm2),
                region.transient_s,
            )
            for region in self.regions
        ]
        return core.BodyLimits(regions, silent_n)

    def _cells(self, region: Region, layout: Layout) -> list[int]:
        found: set[int] = set()
        worn = sorted({layout.links[index] for index in layout.link})
        for link in region.links:
            if link not in worn:
                raise UnknownNameError(f"link with cells, for region {region.name!r} of {self.file},", link, worn)
            found.update(int(cell) for cell in layout.cells_on(link))
        names = [patch.name for patch in layout.patches]
        for patch in region.patches:
            if patch not in names:
                raise UnknownNameError(f"patch, for region {region.name!r} of {self.file},", patch, names)
            found.update(cell for cell in range(len(layout)) if names[layout.patch[cell]] == patch)
        keys = {
            (int(unit), int(cell)): index
            for index, (unit, cell) in enumerate(zip(layout.group, layout.id, strict=True))
        }
        for key in region.cells:
            if key not in keys:
                raise BodyLimitsError(
                    f"{self.file}: region {region.name!r}: there is no cell {key[1]} of section unit {key[0]}; the "
                    f"skin of {layout.robot} has section units {_listed({unit for unit, _ in keys})}"
                )
            found.add(keys[key])
        return sorted(found)


def _checked(values: dict[str, Any], file: str) -> tuple[str, tuple[Region, ...]]:
    for name in values:
        if name not in ("source", "region"):
            raise BodyLimitsError(f"{file}: unknown entry {name!r}; there are source and [[region]]")
    source = values.get("source", "")
    if not isinstance(source, str):
        raise BodyLimitsError(f"{file}: source is {source!r}, it must be a text")
    given = values.get("region", [])
    if not isinstance(given, list) or not all(isinstance(one, dict) for one in given):
        raise BodyLimitsError(f"{file}: region must be a table in double brackets, [[region]]")
    regions = tuple(_region(one, f"{file}: region {number}") for number, one in enumerate(given, start=1))
    if regions and not source.strip():
        raise BodyLimitsError(
            f"{file}: source is empty: limits of contact must say where they come from (standard, edition, table, risk "
            f"assessment)"
        )
    names = [region.name for region in regions]
    for name in names:
        if names.count(name) > 1:
            raise BodyLimitsError(f"{file}: there are {names.count(name)} regions of the name {name!r}")
    return source.strip(), regions


def _region(values: dict[str, Any], where: str) -> Region:
    for field in values:
        if field not in FIELDS:
            raise BodyLimitsError(f"{where}: unknown field {field}; there are {', '.join(FIELDS)}")
    name = values.get("name")
    if not isinstance(name, str) or not 0 < len(name.encode()) < 48:
        raise BodyLimitsError(f"{where}: name is {name!r}, it must be a text of 1 to 47 bytes")
    where = f"{where} ({name})"
    if not any(values.get(part) for part in PARTS):
        raise BodyLimitsError(f"{where}: no part of the robot: give {', '.join(PARTS[:-1])} or {PARTS[-1]}")
    numbers = {
        field: _positive(values[field], f"{where}: {field}") for field in (*LIMITS, "transient_s") if field in values
    }
    if not any(limit in numbers for limit in LIMITS):
        raise BodyLimitsError(f"{where}: no limit: give at least one of {', '.join(LIMITS)}")
    transient = [limit for limit in LIMITS if limit.startswith("transient") and limit in numbers]
    if transient and "transient_s" not in numbers:
        raise BodyLimitsError(f"{where}: {transient[0]} without transient_s, how long a contact is transient")
    return Region(
        name,
        _texts(values.get("links", []), f"{where}: links"),
        _texts(values.get("patches", []), f"{where}: patches"),
        _keys(values.get("cells", []), f"{where}: cells"),
        **numbers,
    )


def _positive(value: Any, where: str) -> float:
    if isinstance(value, bool) or not isinstance(value, int | float) or not 0 < value < math.inf:
        raise BodyLimitsError(f"{where} is {value!r}, it must be a finite number greater than 0")
    return float(value)


def _texts(value: Any, where: str) -> tuple[str, ...]:
    if not isinstance(value, list) or not all(isinstance(one, str) for one in value):
        raise BodyLimitsError(f"{where} is {value!r}, it must be a list of names")
    return tuple(value)


def _keys(value: Any, where: str) -> tuple[tuple[int, int], ...]:
    def whole(one: Any) -> bool:
        return isinstance(one, int) and not isinstance(one, bool)

    if not isinstance(value, list) or not all(
        isinstance(one, list) and len(one) == 2 and all(whole(number) for number in one) for one in value
    ):
        raise BodyLimitsError(f"{where} is {value!r}, it must be a list of [section unit, id]")
    return tuple((unit, cell) for unit, cell in value)


def _listed(values: Iterable[int]) -> str:
    return ", ".join(str(value) for value in sorted(values))
