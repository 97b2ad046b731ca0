# SPDX-License-Identifier: Apache-2.0
"""The moments of a running skin, for programs that look on: its recorder's tapes, played as they are written.

Threads of driver and control do nothing for it beyond what they do for a recording. A follower that falls behind drops
and counts, and goes on at the next keyframe.
"""

from __future__ import annotations

import queue
import threading
import time
from collections.abc import Callable, Mapping
from typing import Any, Protocol

from robotskin.errors import InputError
from robotskin.layout import Layout
from robotskin.record import Frame
from robotskin.record.tape import Player
from robotskin.skin import SkinState

BACKLOG_BYTES_MAX = 64 << 20
PLAYED_BYTES_MAX = 1 << 20
"""Behind by more than this, a moment is passed over to catch up."""


class Show(Protocol):
    """What is shown moments: a server, a bridge."""

    @property
    def period_s(self) -> float:
        """How far apart the moments are to be."""

    def show(self, frame: Frame, stamp_ns: int) -> None:
        """A moment, and its time in nanoseconds since 1970; the frame's arrays are valid during the call."""

    def tell_network(self, topology: Mapping[str, Any], statistics: Mapping[str, int], stamp_ns: int) -> None:
        """Some times a second: what the cells report about their neighbours, and the driver's counts."""

    def close(self) -> None:
        """End."""


NETWORK_S = 0.5


class Follower:
    """Shows the moments of a running skin to several others, on a thread of its own; a `Recorder` feeds it."""

    def __init__(self, layout: Layout, shows: list[Show]) -> None:
        self.shows = shows
        self.shown = 0
        """Moments shown so far."""
        self.dropped = 0
        """Blocks of the tapes for which there was no room."""
        self.failure: Exception | None = None
        """Why nothing is shown any more."""
        self._player, self._state = Player(layout.skin_model()), SkinState(len(layout))
        self._ask: Callable[[], None] = lambda: None
        self._blocks: queue.SimpleQueue[tuple[bytes, bytes] | None] = queue.SimpleQueue()
        self._given_bytes = self._taken_bytes = 0
        self._lost = False
        self.since_1970_ns: int | None = None
        """What is added to the host's clock, on which frames are; set by the first. A simulated world has a clock of
        its own, and is told as if it had run in real time since then."""
        self._due_ns = [0] * len(shows)
        self._network_due_ns = 0
        self._thread = threading.Thread(target=self._work, name="skin follower", daemon=True)
        self._thread.start()

    def _waiting_bytes(self) -> int:
        # Each count is written by one thread alone.
        return self._given_bytes - self._taken_bytes

    # ---- The recorder's thread ----

    def begin(self, ask_for_keyframe: Callable[[], None]) -> None:
        """Blocks will come; `ask_for_keyframe` brings one from which it can go on."""
        self._ask = ask_for_keyframe

    def take(self, driver: bytes, control: bytes, samples: Mapping[str, bytes]) -> None:
        """The next blocks of the two tapes, control first; the samples are in them."""
        if self.failure is not None:
            return
        if self._waiting_bytes() > BACKLOG_BYTES_MAX:
            self.dropped += 1
            self._lost = True
            return
        self._given_bytes += len(driver) + len(control)
        self._blocks.put((driver, control))

    def miss(self) -> None:
        """Blocks will never come: go on at the next keyframe."""
        self.dropped += 1
        self._lost = True

    # ---- Any thread ----

    def close(self) -> None:
        """Show what is left, and end."""
        self._blocks.put(None)
        self._thread.join()
        for one in self.shows:
            one.close()

    @property
    def clock_id(self) -> int:
        """Of the follower's thread, for `time.clock_gettime`: the processor time that it has taken."""
        return time.pthread_getcpuclockid(self._thread.ident or 0)

    # ---- The follower's thread ----

    def _work(self) -> None:
        try:
            while (block := self._blocks.get()) is not None:
                driver, control = block
                self._taken_bytes += len(driver) + len(control)
                self._play(driver, control)
                if self._lost and not self._waiting_bytes():
                    self._lost = False
                    self._player.seek()
                    self._ask()
        except Exception as failure:
            # A program that looks on may fail as it likes: the robot goes on, and the user is told.
            self.failure = failure

    def _play(self, driver: bytes, control: bytes) -> None:
        try:
            if control:
                self._player.give_control(control)
            if driver:
                self._player.give_driver(driver)
            while (time_ns := self._player.advance(self._state)) is not None:
                if self._waiting_bytes() < PLAYED_BYTES_MAX:
                    self._show(time_ns)
        except InputError:
            # Blocks that do not fit each other, after some were dropped.
            self._player.seek()
            self._ask()

    def _show(self, time_ns: int) -> None:
        frame: Frame | None = None
        if self.since_1970_ns is None:
            self.since_1970_ns = time.time_ns() - time_ns
        stamp_ns = time_ns + self.since_1970_ns
        for index, one in enumerate(self.shows):
            if time_ns < self._due_ns[index]:
                continue
            period_ns = round(1e9 * one.period_s)
            self._due_ns[index] = max(self._due_ns[index] + period_ns, time_ns - period_ns)
            frame = frame or self._frame(time_ns)
            one.show(frame, stamp_ns)
            self.shown += 1
        if time_ns >= self._network_due_ns:
            self._network_due_ns = time_ns + round(1e9 * NETWORK_S)
            topology, statistics = self._player.topology(), self._player.statistics()
            for one in self.shows:
                one.tell_network(topology, statistics, stamp_ns)

    def _frame(self, time_ns: int) -> Frame:
        player = self._player
        position, velocity, effort = player.joints
        return Frame(
            time_ns, self._state, position, velocity, effort, player.command, player.command_mode, player.gaps,
            player.measured_force, player.command_by_clock,
        )  # fmt: skip
