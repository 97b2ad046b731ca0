# SPDX-License-Identifier: Apache-2.0
"""All robots of a fleet as one monitor sees them, and its word to stop."""

from __future__ import annotations

import threading
import time
from collections.abc import Iterable
from dataclasses import dataclass, replace
from typing import Self

import zenoh

from robotskin.errors import UnknownNameError
from robotskin.fleet import topics
from robotskin.fleet.errors import FleetError
from robotskin.fleet.link import open_link
from robotskin.fleet.member import Member, Role
from robotskin.fleet.messages import STATE_BYTES_MAX, Order, State, packed, unpacked

STALE_S = 1.0
"""A robot that is connected tells its state more often than this."""
REPEAT_S = 0.01
"""Between two tellings of an order that is not obeyed yet. A robot whose link was mended just now, and that does not
listen yet, misses the first."""


@dataclass(frozen=True)
class Seen:
    """A robot: whether its link lives and since when, what it said last and when; seconds on the monotonic clock."""

    name: str
    alive: bool
    since_s: float
    state: State | None = None
    heard_s: float = 0.0

    def stale_s(self, now_s: float) -> float:
        """How old its last word is; 0 while it is fresh."""
        age_s = now_s - (self.heard_s if self.state is not None else self.since_s)
        return age_s if age_s > STALE_S else 0.0


class FleetWatch:
    """Watches a fleet until `close`.

    Raises FleetError where the router is not reached.
    """

    def __init__(self, member: Member) -> None:
        self.member = member
        self.refused = 0
        """Messages that fitted no type, or came under another robot's key; they changed nothing."""
        self._robots: dict[str, Seen] = {}
        self._changed = threading.Condition()
        self._number = 0
        self._link = open_link(member)
        self._ears = (
            self._link.declare_subscriber(topics.of_robot("*", topics.STATE), self._told),
            self._link.liveliness().declare_subscriber(topics.of_robot("*", topics.ALIVE), self._lives, history=True),
        )

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *_: object) -> None:
        self.close()

    def close(self) -> None:
        """Leave the fleet."""
        self._link.close()

    @property
    def may_stop(self) -> bool:
        """Whether this member is a monitor."""
        return self.member.role == Role.monitor.name

    @property
    def connected(self) -> bool:
        """Whether the router is reached; if not, nothing that is known is fresh."""
        return bool(self._link.info.routers_zid())

    def robots(self) -> dict[str, Seen]:
        """All that were ever seen, by name, in the order of the alphabet."""
        with self._changed:
            return dict(sorted(self._robots.items()))

    def await_robots(self, names: Iterable[str], patience_s: float) -> set[str]:
        """Wait until all of these live and have said something; those that do not."""
        with self._changed:
            missing = set(names)
            ends = time.monotonic() + patience_s
            while True:
                missing = {name for name in missing if not self._is_there(name)}
                if not missing or not self._changed.wait(max(ends - time.monotonic(), 0.0)):
                    return missing

    def _is_there(self, name: str) -> bool:
        seen = self._robots.get(name)
        return seen is not None and seen.alive and seen.state is not None

    def stop(self, names: Iterable[str] | None = None, patience_s: float = 3.0) -> dict[str, float | None]:
        """Stop robots (None: all), told again and again until each says that it obeyed; seconds until then, or None.

        Raises FleetError: this member is no monitor. Raises UnknownNameError for a robot that was never seen.
        """
        if not self.may_stop:
            raise FleetError(f"fleet: {self.member.name} is a {self.member.role}; only a monitor may stop robots")
        seen = self.robots()
        wanted = list(seen) if names is None else list(names)
        for name in wanted:
            if name not in seen:
                raise UnknownNameError("robot of the fleet", name, seen)
        with self._changed:
            number = self._number = max(time.time_ns(), self._number + 1)
        order, began = packed(Order(number, self.member.name)), time.monotonic()
        obeyed: dict[str, float | None] = dict.fromkeys(wanted)
        due_s = began
        while True:
            with self._changed:
                self._changed.wait_for(lambda: self._note(number, obeyed, began), max(due_s - time.monotonic(), 0.0))
            late = [name for name, took_s in obeyed.items() if took_s is None]
            if not late or time.monotonic() - began > patience_s:
                return obeyed
            due_s = time.monotonic() + REPEAT_S
            for name in late:
                self._link.put(
                    topics.stop_of(name), order, express=True, priority=zenoh.Priority.REAL_TIME,
                    congestion_control=zenoh.CongestionControl.BLOCK,
                )  # fmt: skip

    def _note(self, number: int, obeyed: dict[str, float | None], began: float) -> bool:
        """Take down which robots have obeyed an order, or a later one; whether all have."""
        for name, took_s in obeyed.items():
            state = self._robots[name].state
            if took_s is None and state is not None and state.orders.get(self.member.name, 0) >= number:
                obeyed[name] = time.monotonic() - began
        return None not in obeyed.values()

    # ---- Threads of Zenoh ----

    def _told(self, sample: zenoh.Sample) -> None:
        name = topics.robot_of(str(sample.key_expr))
        try:
            state = unpacked(State, sample.payload.to_bytes(), STATE_BYTES_MAX)
        except FleetError:
            self.refused += 1
            return
        now_s = time.monotonic()
        with self._changed:
            before = self._robots.get(name) or Seen(name, alive=True, since_s=now_s)
            self._robots[name] = replace(before, state=state, heard_s=now_s)
            self._changed.notify_all()

    def _lives(self, sample: zenoh.Sample) -> None:
        name = topics.robot_of(str(sample.key_expr))
        alive = sample.kind == zenoh.SampleKind.PUT
        now_s = time.monotonic()
        with self._changed:
            before = self._robots.get(name) or Seen(name, alive=alive, since_s=now_s)
            if before.alive != alive:
                before = replace(before, alive=alive, since_s=now_s)
            self._robots[name] = before
            self._changed.notify_all()
