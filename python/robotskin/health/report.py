# SPDX-License-Identifier: Apache-2.0
"""What a watch found, for people: a table, a picture, figures."""

from __future__ import annotations

from collections import Counter
from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray
from rich.table import Table

from robotskin.health.kinds import Finding, Kind
from robotskin.layout import Layout, picture

if TYPE_CHECKING:
    from robotskin.robots import Robot

WELL_COLOUR = (0.55, 0.72, 0.60)
ILL_COLOUR = (0.85, 0.15, 0.12)


def table(layout: Layout, findings: Sequence[Finding]) -> Table:
    """A row an ill cell: which, where, what, and what to do."""
    out = Table(title=f"{len(findings)} of {len(layout)} cells are ill" if findings else None)
    for heading in ("cell", "unit", "id", "link", "what", "what to do"):
        out.add_column(heading, justify="right" if heading in ("cell", "unit", "id") else "left")
    for one in findings:
        link = layout.links[int(layout.link[one.cell])]
        where = (str(one.cell), str(int(layout.group[one.cell])), str(int(layout.id[one.cell])), link)
        out.add_row(*where, one.told, one.kind.advice)
    return out


def save_picture(layout: Layout, robot: Robot, findings: Sequence[Finding], path: Path) -> None:
    """The robot in its skin from two sides, ill cells red (PNG)."""
    colours: NDArray[np.float64] = np.tile(WELL_COLOUR, (len(layout), 1))
    for one in findings:
        colours[one.cell] = ILL_COLOUR
    picture.save_picture(layout, robot, path, cell_colours=colours)


def figures(layout: Layout, findings: Sequence[Finding], seconds: float) -> dict[str, Any]:
    """Flat: how many cells are ill, and of what; which, as text."""
    count = Counter(one.kind for one in findings)
    out: dict[str, Any] = {"cells": len(layout), "ill": len(findings), "watched_s": seconds}
    out |= {kind.name: count[kind] for kind in Kind}
    out["ill_cells"] = ", ".join(f"{one.cell} {one.kind.name}" for one in findings)
    return out
