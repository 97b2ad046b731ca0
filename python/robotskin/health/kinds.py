# SPDX-License-Identifier: Apache-2.0
"""The ten ways in which a cell may be ill, and that it is cut off by another one; what to do about each."""

from __future__ import annotations

import enum
from dataclasses import dataclass

from robotskin import firmware

CHANNELS: tuple[str, ...] = tuple(name for name, *_ in firmware.CHANNELS)
"""The nine channels by name, in the order of the wire."""


class Kind(enum.Enum):
    """What is wrong with a cell. A cell has one name: the first of these that holds."""

    dead = "it is silent"
    cut_off = "it is silent, and so is every cell that leads to it"
    end_of_range = "a channel stays at the end of its range with nothing there"
    stuck = "a channel does not change any more"
    overheated = "it is much hotter than the cells around it"
    noisy = "a channel is much noisier than those of other cells"
    swapped = "it feels what another cell should feel"
    loose = "its accelerometer is turned against its link"
    mis_scaled = "an axis of its accelerometer shows too much or too little"
    offset = "its zero is wrong"
    drifting = "its zero moves"

    @property
    def title(self) -> str:
        """Its name in words."""
        return self.name.replace("_", " ")

    @property
    def advice(self) -> str:
        """What to do."""
        return _ADVICE[self.name]


_ADVICE = {
    "dead": "look at its connectors and those of its neighbours, then replace it",
    "cut_off": "mend the dead cells first; it may well be alive",
    "end_of_range": "see that nothing presses it; replace it",
    "stuck": "restart the skin; replace it if it stays",
    "overheated": "switch the skin off and look for a short or a hot motor behind it",
    "noisy": "look at its connectors and at motors beside it; replace it",
    "swapped": "exchange the two cells, or configure the skin anew",
    "loose": "fasten it, then configure the skin anew",
    "mis_scaled": "replace it, or leave its acceleration out",
    "offset": "take the zero anew while nothing touches the skin; replace it if it comes back",
    "drifting": "watch it; take the zero often, or replace it",
}

ILLNESSES: tuple[Kind, ...] = tuple(kind for kind in Kind if kind is not Kind.cut_off)
"""The ten of a cell itself."""


@dataclass(frozen=True)
class Finding:
    """One ill cell.

    or_kind: what it may be as well where the evidence cannot tell the two apart, such as on a link that never tilts.
    channels: those that it is of, by name; empty: the whole cell. size: how far off, in `unit`. partner: of a swapped
    cell, the other one; of one that is cut off, the nearest dead one. since_ns: host clock when it was named.
    """

    cell: int
    kind: Kind
    channels: tuple[str, ...] = ()
    size: float = 0.0
    unit: str = ""
    or_kind: Kind | None = None
    partner: int | None = None
    since_ns: int = 0

    @property
    def kinds(self) -> tuple[Kind, ...]:
        """All that it may be."""
        return (self.kind,) if self.or_kind is None else (self.kind, self.or_kind)

    @property
    def told(self) -> str:
        """In words."""
        of = f"{', '.join(self.channels)}: " if self.channels else ""
        size = f" by {self.size:.3g} {self.unit}".rstrip() if self.unit else ""
        other = f", or {self.or_kind.title}" if self.or_kind is not None else ""
        by = "by" if self.kind is Kind.cut_off else "with"
        partner = f" {by} cell {self.partner}" if self.partner is not None else ""
        return f"{of}{self.kind.title}{partner}{size}{other}"
