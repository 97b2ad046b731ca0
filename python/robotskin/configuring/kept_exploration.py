# SPDX-License-Identifier: Apache-2.0
"""A recording of an exploration: what an unknown skin felt while its robot babbled, and where its cells turned out."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from types import TracebackType

import numpy as np
from numpy.typing import NDArray

from robotskin.configuring.exploration import Exploration
from robotskin.driver import Driver
from robotskin.errors import InputError
from robotskin.layout import Layout
from robotskin.layout.json_file import to_text
from robotskin.record import Recorder
from robotskin.robots import Robot
from robotskin.skin import SkinReader

LAYOUT = "layout.json"


@dataclass(frozen=True)
class ExploredSkin:
    """What the recorder sees of an exploration: cells of which only the keys are known, and no loop."""

    robot: Robot
    layout: Layout
    driver: Driver
    reader: SkinReader
    seed: int
    loop: None = None
    behaviour: str = "babbling"
    interface: str = "position"


class KeptExploration:
    """Records an exploration into a new file, while a `with` block lasts.

    The file's layout has all cells at the robot's base until `found` tells where they are.

    Raises InputError: there is such a file.
    """

    def __init__(self, path: Path) -> None:
        if path.exists():
            raise InputError(f"--record {path}: it exists: choose another name")
        self.path = path
        self._layout: Layout | None = None
        self._recorder: Recorder | None = None

    def begin(self, exploration: Exploration) -> None:
        """Record from now on. Raises RecordError where the file cannot be written."""
        self._layout = unplaced_layout(exploration.robot, exploration.keys)
        skin = ExploredSkin(
            exploration.robot, self._layout, exploration.driver, exploration.reader, exploration.world.seed
        )
        self._recorder = Recorder(self.path, skin)
        exploration.moved = self._recorder.moved

    def found(self, layout: Layout) -> None:
        """Keep where the cells are; those that are not in the layout stay at the base."""
        if self._recorder is not None and self._layout is not None:
            self._recorder.attach_late(LAYOUT, to_text(placed_in(self._layout, layout)))

    @property
    def dropped(self) -> int:
        """Entries for which the recorder had no room."""
        return 0 if self._recorder is None else self._recorder.dropped

    def __enter__(self) -> KeptExploration:
        return self

    def __exit__(self, *_: type[BaseException] | BaseException | TracebackType | None) -> None:
        if self._recorder is not None:
            self._recorder.close()


def unplaced_layout(robot: Robot, keys: NDArray[np.int64]) -> Layout:
    """The layout of cells of which only the keys (N,) are known: all at the robot's base, none beside another."""
    count = len(keys)
    return Layout(
        robot.name,
        (robot.base_link,),
        (keys & 0xFFFF).astype(np.uint16),
        (keys >> 16).astype(np.uint16),
        np.zeros(count, np.int32),
        np.tile(np.eye(4), (count, 1, 1)),
        np.full((count, 4, 2), (-1, 0), np.int32),
        np.full(count, -1, np.int32),
    )


def placed_in(layout: Layout, found: Layout) -> Layout:
    """The same cells in the same order, each on the link and at the place that another layout has for it."""
    here = layout.cells_of(found.keys)
    links = (*layout.links, *(name for name in found.links if name not in layout.links))
    link, pose = np.array(layout.link), np.array(layout.link_from_cell)
    link[here] = np.array([links.index(name) for name in found.links])[found.link]
    pose[here] = found.link_from_cell
    return Layout(layout.robot, links, layout.id, layout.group, link, pose, layout.neighbours, layout.patch)
