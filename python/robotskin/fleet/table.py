# SPDX-License-Identifier: Apache-2.0
"""A fleet as rows of words: the same for the terminal and for the page."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass

from rich.table import Table

from robotskin.fleet.messages import State
from robotskin.fleet.watch import FleetWatch, Seen

HEADINGS = ("robot", "link", "state", "skin whole", "touched", "ill cells")
TOUCHES_TOLD = 3


@dataclass(frozen=True)
class Row:
    """One robot in words. fresh: whether what it says is of now; else its contacts are left out."""

    name: str
    link: str
    state: str
    skin: str
    touched: str
    ill: str
    fresh: bool

    @property
    def cells(self) -> tuple[str, ...]:
        """In the order of `HEADINGS`."""
        return self.name, self.link, self.state, self.skin, self.touched, self.ill


def rows(robots: Mapping[str, Seen], now_s: float, connected: bool = True) -> list[Row]:
    """One for each robot. connected: whether the monitor itself reaches the router."""
    return [_row(seen, now_s, connected) for seen in robots.values()]


def table(robots: Mapping[str, Seen], now_s: float, connected: bool = True) -> Table:
    """For the terminal; what is not fresh is dim."""
    out = Table(*HEADINGS)
    for row in rows(robots, now_s, connected):
        out.add_row(*row.cells, style="" if row.fresh else "dim")
    return out


def stops_told(took: Mapping[str, float | None]) -> list[str]:
    """How an order to stop went, a line a robot."""
    told = [
        f"{name}: " + (f"obeyed after {took_s * 1e3:.0f} ms" if took_s is not None else "DID NOT ANSWER")
        for name, took_s in took.items()
    ]
    return told or ["no robot is in the fleet"]


def stop_told(watch: FleetWatch, names: list[str] | None) -> str:
    """Stop robots (None: all), and how it went."""
    return "; ".join(stops_told(watch.stop(names)))


def _row(seen: Seen, now_s: float, connected: bool) -> Row:
    state, stale_s = seen.state, seen.stale_s(now_s)
    if not connected:
        link = "not known: no router"
    elif not seen.alive:
        link = f"{'left' if state is not None and state.state == 'ended' else 'lost'} {now_s - seen.since_s:.0f} s ago"
    elif stale_s:
        link = f"silent for {stale_s:.0f} s"
    else:
        link = "live"
    fresh = link == "live" and state is not None
    if state is None:
        return Row(seen.name, link, "nothing said yet", "", "", "", fresh)
    said = f"{state.behaviour}: {state.state}" + (f" ({state.reason})" if state.reason else "")
    told = said if fresh else f"last: {said}"
    return Row(seen.name, link, told, _skin(state), _touched(state) if fresh else "not known", _ill(state), fresh)


def _skin(state: State) -> str:
    alive = state.health.get("alive", 0)
    whole = alive / state.cells if state.cells else 0.0
    # Never rounded up to a whole skin.
    return f"{math.floor(1000 * whole) / 10:g}% ({alive} of {state.cells})"


def _touched(state: State) -> str:
    told = [
        f"{one.link} {math.sqrt(sum(newton * newton for newton in one.force)):.1f} N"
        for one in state.contacts[:TOUCHES_TOLD]
    ]
    more = len(state.contacts) - TOUCHES_TOLD
    return ", ".join(told) + (f" and {more} more" if more > 0 else "") or "nothing"


def _ill(state: State) -> str:
    if state.ill is None:
        return "not watched"
    return ", ".join(f"{count} {kind.replace('_', ' ')}" for kind, count in state.ill.items()) or "none"
