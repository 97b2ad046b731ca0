# SPDX-License-Identifier: Apache-2.0
"""A running robot in its fleet: its skin is published from the recorder's tapes, and it obeys stop.

A thread of its own connects and sends. Without a router the robot goes on, and joins when there is one.
"""

from __future__ import annotations

import collections
import secrets
import threading
import time
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Any

import msgspec
import numpy as np
import zenoh

from robotskin.fleet import topics
from robotskin.fleet.errors import FleetError
from robotskin.fleet.link import open_link
from robotskin.fleet.member import Member
from robotskin.fleet.messages import ORDER_BYTES_MAX, About, Contact, Order, State, packed, unpacked
from robotskin.fleet.streams import BATCH_S, Stream
from robotskin.fleet.tape import TAPE, events_in
from robotskin.layout import Layout
from robotskin.record import Frame
from robotskin.record.facts import Recorded, about_of, attachments_of
from robotskin.sharing.contacts import contacts
from robotskin.skin import Health

SETTLE_S = 0.3
"""Until those that listen have found the streams: then none of them misses the first messages."""
STATE_S = 0.2
"""Between two states that are told."""
BACKLOG_BYTES_MAX = 32 << 20
"""Of blocks that wait for a router; beyond it they are dropped and counted."""
MESSAGE_BYTES = 4 << 20
MONITORS_MAX = 50
ENDED = "ended"
"""The state of one that leaves."""


@dataclass(frozen=True)
class Told:
    """What a robot says of itself. ill: cells by `robotskin.health.Kind`; None: they are not watched."""

    behaviour: str
    state: str
    reason: str = ""
    ill: Mapping[str, int] | None = None


def published(
    member: Member,
    session: Recorded,
    look: Callable[[], Told],
    obey: Callable[[str], None],
    tell: Callable[[str], None] = lambda text: None,
) -> PublishedRobot:
    """A session that runs, as `PublishedRobot`."""
    return PublishedRobot(member, session.layout, about_of(session), attachments_of(session), look, obey, tell)


class PublishedRobot:
    """A `Show` and a follower of the recorder at once, until `close`.

    Args:
        member: of the role robot. layout: of its skin. facts, attachments: as a recording holds them
        (`robotskin.record.facts`). look: what the robot does as of now, from any thread.
        obey: stops the robot, from any thread; it hears why. tell: hears when the router is reached, or is not.
    """

    def __init__(
        self,
        member: Member,
        layout: Layout,
        facts: Mapping[str, str],
        attachments: Mapping[str, str],
        look: Callable[[], Told],
        obey: Callable[[str], None],
        tell: Callable[[str], None] = lambda text: None,
    ) -> None:
        self.period_s = STATE_S
        self.look = look
        self.dropped = 0
        """Blocks that could not be sent."""
        self.name = member.name
        self.run = secrets.randbits(63)
        self._member, self._obey, self._tell_user = member, obey, tell
        self._layout = layout
        self._about = packed(About(run=self.run, facts=dict(facts), attachments=dict(attachments)))
        self._ask: Callable[[], None] = lambda: None
        self._blocks: collections.deque[tuple[bytes, bytes, bytes]] = collections.deque()
        self._waiting_bytes = 0
        self._lock, self._telling = threading.Lock(), threading.RLock()
        self._state: State | None = None
        self._orders: dict[str, int] = {}
        self._obeyed_ns = 0
        self._link: zenoh.Session | None = None
        self._closing = threading.Event()
        self._thread = threading.Thread(target=self._work, name="fleet", daemon=True)
        self._thread.start()

    @property
    def connected(self) -> bool:
        """Whether the router is reached at present."""
        link = self._link
        return link is not None and bool(link.info.routers_zid())

    # ---- The recorder's thread ----

    def begin(self, ask_for_keyframe: Callable[[], None]) -> None:
        """Blocks will come."""
        self._ask = ask_for_keyframe

    def take(self, driver: bytes, control: bytes, samples: Mapping[str, bytes]) -> None:
        """The next blocks of the two tapes, and what is decoded of them."""
        events = events_in(samples)
        size = len(driver) + len(control) + len(events)
        with self._lock:
            if self._waiting_bytes + size > BACKLOG_BYTES_MAX:
                self.dropped += 1
                return
            self._waiting_bytes += size
            self._blocks.append((driver, control, events))

    # ---- The follower's thread ----

    def show(self, frame: Frame, stamp_ns: int) -> None:
        """A moment: tell how robot and skin are."""
        told = self.look()
        health = np.bincount(np.asarray(frame.skin.health), minlength=len(Health))
        touched = contacts(self._layout, frame.skin)
        state = State(
            run=self.run, stamp_ns=stamp_ns, robot=self._layout.robot, behaviour=told.behaviour, state=told.state,
            reason=told.reason, cells=len(self._layout),
            health={one.name: int(health[one.value]) for one in Health if health[one.value]},
            ill=None if told.ill is None else dict(told.ill),
            contacts=tuple(
                Contact(one.link, one.cells, *(tuple(map(float, values)) for values in (  # type: ignore[arg-type]
                    one.position, one.normal, one.force, one.torque)))
                for one in touched
            ),
            dropped=self.dropped,
        )  # fmt: skip
        self._publish(state)

    def tell_network(self, topology: Mapping[str, Any], statistics: Mapping[str, int], stamp_ns: int) -> None:
        """The network is not told."""

    # ---- Any thread ----

    def close(self) -> None:
        """Send what is left, and leave."""
        self._closing.set()
        self._thread.join()

    def _publish(self, state: State) -> None:
        with self._telling:
            if self._state is not None and self._state.state == ENDED:
                return
            self._state = msgspec.structs.replace(state, orders=dict(self._orders), obeyed_ns=self._obeyed_ns)
            link = self._link
            if link is not None:
                link.put(topics.of_robot(self.name, topics.STATE), packed(self._state), express=True)

    # ---- Threads of Zenoh ----

    def _ordered(self, sample: zenoh.Sample) -> None:
        # SAFETY: stopped first, told afterwards. An order told again does not stop a robot that was started since.
        try:
            order = unpacked(Order, sample.payload.to_bytes(), ORDER_BYTES_MAX)
        except FleetError:
            return
        with self._telling:
            if self._orders.get(order.by) == order.number:
                return
            self._obey(f"stopped by {order.by} of the fleet; only its own page or terminal starts it again")
            if len(self._orders) >= MONITORS_MAX:
                self._orders.clear()
            self._orders[order.by], self._obeyed_ns = order.number, time.monotonic_ns()
            if self._state is not None:
                told = self.look()
                self._publish(msgspec.structs.replace(self._state, state=told.state, reason=told.reason))

    # ---- Its own thread ----

    def _work(self) -> None:
        link = self._open()
        if link is None:
            return
        key = topics.of_robot
        tape = Stream(link, key(self.name, topics.TAPE), self.run)
        events = Stream(link, key(self.name, topics.EVENTS), self.run)
        about = key(self.name, topics.ABOUT)
        ends: list[Any] = [
            link.declare_queryable(about, lambda query: query.reply(about, self._about)),
            link.declare_subscriber(topics.stop_of(self.name), self._ordered),
            link.liveliness().declare_token(key(self.name, topics.ALIVE)),
        ]
        self._link = link
        self._closing.wait(SETTLE_S)
        self._ask()
        told_dropped = 0
        while True:
            last = self._closing.wait(BATCH_S)
            while self._send(tape, events):
                pass
            if self.dropped > told_dropped:
                told_dropped = self.dropped
                tape.skip()
                events.skip()
                self._ask()
            if last:
                break
        if self._state is not None:
            self._publish(msgspec.structs.replace(self._state, state=ENDED, reason="", contacts=()))
        for one in ends:
            one.undeclare()
        tape.close()
        events.close()
        self._link = None
        link.close()

    def _open(self) -> zenoh.Session | None:
        told = False
        while not self._closing.is_set():
            try:
                link = open_link(self._member, 1.0)
                self._tell_user(f"fleet: {self.name} is in the fleet of the router at {self._member.router}")
                return link
            except FleetError as error:
                if not told:
                    self._tell_user(f"{error}; the robot goes on, and joins when there is one")
                told = True
        return None

    def _send(self, tape: Stream, events: Stream) -> bool:
        """One message of each stream, where something waits; whether something was left."""
        taken: list[tuple[bytes, bytes, bytes]] = []
        size = 0
        with self._lock:
            while self._blocks and size < MESSAGE_BYTES:
                taken.append(self._blocks.popleft())
                size += sum(map(len, taken[-1]))
            self._waiting_bytes -= size
            left = bool(self._blocks)
        if taken:
            driver, control, felt = (b"".join(parts) for parts in zip(*taken, strict=True))
            tape.put(TAPE.pack({"driver": driver, "control": control}))
            if felt:
                events.put(felt)
        return left
