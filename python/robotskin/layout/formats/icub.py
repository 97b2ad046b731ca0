# SPDX-License-Identifier: Apache-2.0
"""iCub taxel files: a row `x y z nx ny nz` a taxel, metres, link frame; a row of zeros is an empty slot."""

import re
from pathlib import Path

import numpy as np

from robotskin.layout.raw_layout import Defect, RawCell, RawLayout

FORMAT = "iCub taxel text"
TRIANGLE = 12
"""Slots of a triangle; slots 6 and 10 are temperature pads and not taxels."""
TEMPERATURE_SLOTS = (6, 10)


def read(text: str, path: Path) -> RawLayout:
    """Read the taxels that are there; a row that is no row of six numbers becomes a defect."""
    header, _, body = text.partition("[calibration]")
    name = re.search(r"^\s*name\s+(\S+)", header, re.MULTILINE)
    represented = re.search(r"^\s*taxel2Repr\s*\(([^)]*)\)", header, re.MULTILINE)
    skin = RawLayout(str(path), FORMAT)
    first_line = header.count("\n") + 1
    rows: list[bool] = []
    for offset, line in enumerate(body.splitlines()):
        words = line.split()
        if not words or line.lstrip().startswith(("#", "//")):
            continue
        if line.lstrip().startswith("["):
            break
        row = len(rows)
        where = f"row {row}"
        try:
            values = np.array([float(word) for word in words])
            if len(values) != 6:
                raise ValueError(f"{len(values)} numbers")
        except ValueError as error:
            shown = " ".join(words)[:60]
            why = f"line {first_line + offset}: a row has six numbers x y z nx ny nz; {error}"
            skin.defects.append(Defect("bad_row", where, shown, why))
            rows.append(False)
            continue
        there = bool(np.any(values != 0))
        rows.append(there)
        if not there:
            skin.empty += 1
            continue
        link = name.group(1) if name else ""
        skin.cells.append(RawCell(where, None, 0, row // TRIANGLE, link, values[:3], values[3:]))
    if represented is not None:
        _check_representatives(skin, represented.group(1).split(), rows)
    return skin


def _check_representatives(skin: RawLayout, words: list[str], rows: list[bool]) -> None:
    """taxel2Repr gives each slot the slot that stands for it, -1 for an unused one, -2 for a temperature pad."""
    if len(words) != len(rows):
        skin.defects.append(Defect("count", "taxel2Repr", f"{len(words)} entries", f"the file has {len(rows)} rows"))
    for row, (word, there) in enumerate(zip(words, rows, strict=False)):
        if not re.fullmatch(r"-?\d+", word):
            skin.defects.append(Defect("bad_row", f"taxel2Repr {row}", word, "must be an integer"))
        elif int(word) >= 0 and not there:
            skin.defects.append(
                Defect("missing_pose", f"row {row}", f"taxel2Repr {word}", "in use, but its row is all zero")
            )
        elif int(word) >= len(rows):
            skin.defects.append(Defect("unknown_representative", f"row {row}", word, f"rows are 0 to {len(rows) - 1}"))
