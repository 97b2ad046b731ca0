# SPDX-License-Identifier: Apache-2.0
"""Layouts of a part of a skin."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from robotskin.layout import Layout


def part_of(skin: Layout, rows: NDArray[np.integer]) -> Layout:
    """The layout of these cells alone (indices, in this order), with the cables that end at them."""
    new = np.full(len(skin), -1)
    new[rows] = np.arange(len(rows))
    other = np.where(skin.neighbours[rows, :, 0] >= 0, new[skin.neighbours[rows, :, 0]], -1)
    port = np.where(other >= 0, skin.neighbours[rows, :, 1], 0)
    numbers = np.unique(skin.patch[rows])
    return replace(
        skin,
        id=skin.id[rows],
        group=skin.group[rows],
        link=skin.link[rows],
        link_from_cell=skin.link_from_cell[rows],
        neighbours=np.stack([other, port], axis=2).astype(np.int32),
        patch=np.searchsorted(numbers, skin.patch[rows]).astype(np.int32),
        patches=tuple(replace(skin.patches[number], root=int(new[skin.patches[number].root])) for number in numbers),
        section_unit_ports=tuple(
            replace(place, cell=int(new[place.cell])) for place in skin.section_unit_ports if new[place.cell] >= 0
        ),
        studs=(),
        cables=(),
    )
