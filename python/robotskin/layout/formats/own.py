# SPDX-License-Identifier: Apache-2.0
"""The project's own layout JSON, read leniently so that every defect can be named and not only the first."""

import json
from pathlib import Path
from typing import Any

import numpy as np

from robotskin.layout.cell import PORTS
from robotskin.layout.json_file import pointer, validator
from robotskin.layout.old_words import in_todays_words
from robotskin.layout.raw_layout import Defect, RawCell, RawLayout

MOST_SCHEMA_DEFECTS = 200


def read(text: str, path: Path) -> RawLayout:
    """Read what can be read; whatever breaks the schema becomes a defect."""
    document = in_todays_words(json.loads(text))
    skin = RawLayout(str(path), "robotskin JSON", robot=document.get("robot"))
    urdf = document.get("urdf")
    if isinstance(urdf, str) and (path.absolute().parent / urdf).is_file():
        skin.urdf = str(path.absolute().parent / urdf)
    for error, _ in zip(validator().iter_errors(document), range(MOST_SCHEMA_DEFECTS), strict=False):
        skin.defects.append(
            Defect("schema", pointer(error.absolute_path), repr(error.instance)[:60], error.message[:160])
        )
    cells = document.get("cells")
    for index, cell in enumerate(cells if isinstance(cells, list) else []):
        found = _cell(cell, index, cells)
        if found is not None:
            skin.cells.append(found)
    return skin


def _cell(cell: Any, index: int, cells: list[Any]) -> RawCell | None:
    try:
        rotation = np.array(cell["rotation"], dtype=float).reshape(3, 3)
        neighbours, ports = [0] * PORTS, [0] * PORTS
        for port, entry in enumerate(list(cell["neighbours"])[:PORTS]):
            if entry is not None:
                # The file counts cells from 0; the common form uses ids, and an index beyond the file has none.
                other, ports[port] = int(entry[0]), int(entry[1])
                neighbours[port] = int(cells[other]["id"]) if 0 <= other < len(cells) else -other - 1
        position = np.array(cell["position_m"], dtype=float).reshape(3)
        return RawCell(
            f"cell {cell['id']} (index {index})",
            int(cell["id"]),
            int(cell["group"]),
            int(cell.get("patch", -1)),
            str(cell["link"]),
            position,
            rotation[:, 2],
            rotation,
            tuple(neighbours),
            tuple(ports),
        )
    except (KeyError, IndexError, TypeError, ValueError):
        # Already named by the schema; such a cell cannot be looked at further.
        return None
