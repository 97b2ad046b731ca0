# SPDX-License-Identifier: Apache-2.0
"""Which of the cells that a robot wears are those of another layout of it."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from robotskin.errors import InputError
from robotskin.layout import Layout


def cells_in(worn: Layout, estimated_layout: Layout) -> NDArray[np.int64]:
    """(N,) index in the worn layout of each cell of the believed one, by key.

    Raises:
        InputError: a cell that the robot does not wear, or a layout of another robot.
    """
    if worn.robot != estimated_layout.robot:
        raise InputError(f"layout of {estimated_layout.robot}: the robot is {worn.robot}")
    row = {(int(group), int(cell)): index for index, (group, cell) in enumerate(zip(worn.group, worn.id, strict=True))}
    keys = [(int(group), int(cell)) for group, cell in zip(estimated_layout.group, estimated_layout.id, strict=True)]
    unknown = [key for key in keys if key not in row]
    if unknown:
        raise InputError(f"cell {unknown[0][1]} of section unit {unknown[0][0]}: the robot wears no such cell")
    return np.array([row[key] for key in keys], dtype=np.int64)
