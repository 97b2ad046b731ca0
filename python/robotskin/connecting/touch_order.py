# SPDX-License-Identifier: Apache-2.0
"""Whether cells are where the layout says: each of a few marked cells must be the one that feels a touch.

A wrong layout of the right cells passes every check of wires and versions; only a hand knows where a cell is.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from robotskin.layout import Layout
from robotskin.skin import Health, SkinState

MOST_CELLS = 3
TOUCH_N = 1.5
"""Force of a cell that is touched; what skins without force must come near to is `TOUCH_NEAR`."""
TOUCH_NEAR = 0.6
HOLD_S = 0.15
"""For which one cell must be the most touched."""
BESIDE = 0.5
"""A marked cell that feels this share of the most touched one's is touched, too: a finger covers several."""
MOST_WRONG = 3
"""Touches of other cells in place of one, after which it is no slip."""


def marked_cells(layout: Layout, most: int = MOST_CELLS) -> list[int]:
    """Rows of cells on different patches, those of cables first; each far from the middle of its patch.

    A patch that is turned or mirrored has another cell there. A skin of one patch gives two cells, far apart.
    """
    wired = [int(layout.patch[port.cell]) for port in layout.section_unit_ports]
    patches = list(dict.fromkeys([*wired, *(int(one) for one in layout.patch)]))
    links = [int(layout.link[layout.patch == patch][0]) for patch in patches]
    first_on_link = [links.index(link) == at for at, link in enumerate(links)]
    # Those on a link of their own come first.
    chosen = sorted(range(len(patches)), key=lambda at: not first_on_link[at])[:most]
    found = []
    for at in sorted(chosen):
        cells = np.flatnonzero(layout.patch == patches[at])
        places = layout.link_from_cell[cells][:, :3, 3]
        farthest = int(np.linalg.norm(places - places.mean(axis=0), axis=1).argmax())
        found.append(int(cells[farthest]))
        if len(patches) == 1:
            opposite = int(cells[np.linalg.norm(places - places[farthest], axis=1).argmax()])
            found += [opposite] if opposite != found[0] else []
    return found


class TouchOrder:
    """Asks for a touch of each marked cell in turn, and says which one was touched instead.

    Args:
        layout: N cells.
        cells: rows of the marked ones; by default `marked_cells`.
    """

    def __init__(self, layout: Layout, cells: list[int] | None = None) -> None:
        self.layout = layout
        self.cells = marked_cells(layout) if cells is None else cells
        self.found = ""
        """What the last touch showed; empty before the first."""
        self._at = self._wrong = 0
        self._top, self._since_s = -1, 0.0
        self._released = False

    @property
    def marked(self) -> int | None:
        """Row of the cell to touch; None: all have been."""
        return self.cells[self._at] if self._at < len(self.cells) else None

    @property
    def refused(self) -> bool:
        """Whether other cells were touched so often that the layout is not that of this skin."""
        return self._wrong >= MOST_WRONG

    @property
    def told(self) -> str:
        """What is asked for, after what was found."""
        if self.marked is None:
            return self.found
        asked = f"touch the marked {self.place(self.marked)} ({self._at + 1} of {len(self.cells)})"
        return f"{self.found}; {asked}" if self.found else asked

    def place(self, cell: int) -> str:
        """A cell and where the layout has it."""
        x, y, z = self.layout.link_from_cell[cell][:3, 3]
        return f"cell {cell} on {self.layout.links[self.layout.link[cell]]} at ({x:.3f}, {y:.3f}, {z:.3f}) m"

    def look(self, skin: SkinState, now_s: float) -> bool:
        """Look at the skin of this moment; whether a touch has been judged."""
        if self.marked is None:
            return False
        felt, least = felt_by(skin)
        top = int(felt.argmax())
        if felt[top] < least:
            self._top, self._released = -1, True
            return False
        if not self._released:  # a touch is judged once
            return False
        if top != self._top:
            self._top, self._since_s = top, now_s
        if now_s - self._since_s < HOLD_S:
            return False
        self._judge(top, bool(felt[self.marked] >= max(least, BESIDE * felt[top])))
        self._released = False
        return True

    def _judge(self, top: int, right: bool) -> None:
        assert self.marked is not None
        if right:
            self.found, self._wrong = f"cell {self.marked} was touched, as marked", 0
            self._at += 1
            return
        self._wrong += 1
        self.found = f"found {self.place(top)} touched, expected cell {self.marked}"


def felt_by(skin: SkinState) -> tuple[NDArray[np.float64], float]:
    """(N,) what living cells feel, by force or else by nearness, and the least that is a touch."""
    alive = np.asarray(skin.health) == int(Health.alive)
    if "force" in skin.sensors:
        felt, least = np.nansum(np.asarray(skin.normal_force, dtype=float), axis=1), TOUCH_N
    else:
        felt, least = np.nan_to_num(np.asarray(skin.proximity, dtype=float)), TOUCH_NEAR
    return np.where(alive, felt, 0.0), least
