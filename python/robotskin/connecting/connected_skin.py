# SPDX-License-Identifier: Apache-2.0
"""What a connected robot asks of its skin."""

from __future__ import annotations

from typing import Protocol

from robotskin.driver import Driver
from robotskin.layout import Layout
from robotskin.skin import SkinInput, SkinReader


class ConnectedSkin(Protocol):
    """A skin that is really there: `SectionUnits`, or `robotskin.foreign.ForeignSkin`."""

    @property
    def layout(self) -> Layout:
        """Its N cells."""

    @property
    def input(self) -> SkinInput:
        """Of a loop."""

    @property
    def driver(self) -> Driver | None:
        """None: not our cells."""

    @property
    def reader(self) -> SkinReader | None:
        """None: not our cells."""

    @property
    def error(self) -> str:
        """Why it ended before its time; empty where it did not."""

    def await_skin(self) -> int:
        """Wait until it speaks; how many of its cells do. Raises a RobotskinError that says why it does not."""

    def tare(self, seconds: float) -> None:
        """Take the forces' zero from the coming `seconds`, in the loop's thread."""

    def statistics(self) -> dict[str, int]:
        """Counts since the beginning: frames of cells, accepted messages, frames missing, time of the processor."""

    def close(self) -> None:
        """End."""
