# SPDX-License-Identifier: Apache-2.0
"""Where contact is allowed in an embrace: the chest's front and the inside of both arms."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from robotskin.apps.embrace.arms import CHEST, SIDES, Arms
from robotskin.layout import Layout
from robotskin.session import SessionError

Array = NDArray[np.float64]
_FORWARD, _INWARD = 0.8, 0.2
"""Least part of a cell's normal straight ahead on the chest, and towards the axis on the arms."""
_MIDDLE_M = 0.07
"""Of the chest, to both sides."""
LEAST_CELLS = 10
"""Of each area: with fewer the arms would close on what they cannot feel."""


@dataclass(frozen=True, eq=False)
class Areas:
    """Indices of the cells that may be touched, by area: `left` and `right` arm, `chest`.

    middle_of_chest: those of the chest that see what the arms bring, and not the arms beside it.
    """

    cells: dict[str, NDArray[np.int64]]
    middle_of_chest: NDArray[np.int64]
    total: int

    @property
    def allowed(self) -> NDArray[np.bool_]:
        """(N,) cells on which contact is allowed and nearness is silent."""
        result = np.zeros(self.total, dtype=bool)
        for cells in self.cells.values():
            result[cells] = True
        return result


def areas_of(arms: Arms, layout: Layout, closed: Array, axis_m: float) -> Areas:
    """The areas of a skin, where the arms are `closed` (n) rad around an axis `axis_m` before the chest's joint.

    Raises:
        SessionError: an area with fewer than `LEAST_CELLS` cells, as in a skin that was not made for this.
    """
    robot = arms.robot
    place = robot.base_from_link(closed)
    links = np.array([robot.link_index(name) for name in layout.links])[layout.link]
    pose = place[links] @ layout.link_from_cell
    names = np.array(layout.links)[layout.link]
    to_axis = arms.origin[:2] + np.array([axis_m, 0.0]) - pose[:, :2, 3]
    to_axis /= np.maximum(np.linalg.norm(to_axis, axis=1, keepdims=True), 1e-9)
    inward = np.einsum("ni,ni->n", pose[:, :2, 2], to_axis)
    cells = {
        side: np.flatnonzero(np.char.startswith(names, f"arm_{side}_") & (inward > _INWARD)).astype(np.int64)
        for side in SIDES
    }
    cells["chest"] = np.flatnonzero((names == CHEST) & (pose[:, 0, 2] > _FORWARD)).astype(np.int64)
    for area, found in cells.items():
        if len(found) < LEAST_CELLS:
            raise SessionError(
                f"embrace with this layout of {layout.robot}: {len(found)} cells of the {area} face what is held, "
                f"{LEAST_CELLS} are needed; use the layout talos_embrace or talos_grasp"
            )
    chest = cells["chest"]
    middle = chest[np.abs(pose[chest, 1, 3] - arms.origin[1]) < _MIDDLE_M]
    return Areas(cells, middle, len(layout))
