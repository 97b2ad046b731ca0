# SPDX-License-Identifier: Apache-2.0
"""A connected robot on a thread of its own, for the page: the view of a simulated session, without its world."""

from __future__ import annotations

import time
from collections.abc import Callable

import numpy as np

from robotskin.choices import member
from robotskin.connecting import ConnectedRobot, TouchOrder
from robotskin.cycle import SafetyState
from robotskin.firmware import CellMode
from robotskin.live.health_beside import HealthBeside
from robotskin.live.live_robot import RATE_WINDOW_S, LiveRobot
from robotskin.session import SessionError
from robotskin.session.reasons import interventions_told
from robotskin.viewer.session_view import SkinReading, Snapshot, Solid

__all__ = ["ConnectedSession"]

SLICE_S = 0.016
TOUCH_IT = "there is no simulated hand: touch the skin itself"


class ConnectedSession(LiveRobot):
    """Runs a `ConnectedRobot` that has begun until `close`, as a `robotskin.viewer.session_view.SessionView`.

    `order`: the robot has only settled, and is started when every marked cell was touched; `tell` says what is asked.
    """

    network = None
    solids: tuple[Solid, ...] = ()

    def __init__(
        self, session: ConnectedRobot, order: TouchOrder | None = None, tell: Callable[[str], None] = print
    ) -> None:
        super().__init__(session, session)
        self.session = session
        self.title = f"{session.robot.name}, {len(session.layout)} cells, connected"
        self.terminal: dict[str, Callable[[], None]] = {"c": self.confirm, "s": self.stop, "g": self.reset}
        """What one letter in the terminal does."""
        self._lookers: Callable[[], int] | None = None
        self._looked = False
        self._page_lost = False
        self._restart = False
        self._order, self._tell = order, tell
        self._began_s = time.monotonic()
        self._rates: dict[str, float] = {}
        self._counted = (self._began_s, session.connected_skin.statistics())
        self._held_back = self._tell_what_holds_back()
        self._health = HealthBeside(session, session.reader)
        self._snapshot = self._take()
        self._begin()

    def watch_page(self, lookers: Callable[[], int]) -> None:
        """Stop the robot where all browsers that looked are gone; `lookers` counts them.

        A page that is loaded anew stops it, too. Whatever hears that one is gone calls `look_for_page`.
        """
        self._lookers = lookers

    def look_for_page(self) -> None:
        """Stop the robot now if its page is gone. Called in each slice, and by any thread that hears of it sooner."""
        if self._lookers is None:
            return
        looks = self._lookers() > 0
        if self._looked and not looks:
            # SAFETY: it cannot be stopped by the page any more.
            self._page_lost, self._restart = True, False
            self.session.stop()
        self._looked = looks

    # ---- What a page or the terminal asks ----

    def push(self, cell: int, force_n: float, duration_s: float | None = None) -> None:
        """Refused: a real skin is touched by hand."""
        raise SessionError(TOUCH_IT)

    def approach(self, cell: int, distance_m: float) -> None:
        """Refused, likewise."""
        raise SessionError(TOUCH_IT)

    def release(self) -> None:
        """There is no hand to take away."""

    def confirm(self) -> None:
        """Full speed."""
        self._ask(self.session.confirm)

    def stop(self) -> None:
        """Stop smoothly, and hold until `reset`."""
        self._ask(self._stop)

    def reset(self) -> None:
        """Start again after a stop."""
        self._ask(self._start_again)

    def set_mode(self, mode: CellMode | str) -> None:
        """Let the cells send in another mode."""
        chosen = member("mode", CellMode, mode)
        self._ask(lambda: self.session.set_mode(chosen))

    def set_source(self, source: str) -> None:
        """Refused but for the host: these cells have not been told how to compute torques."""
        if source != "host":
            raise SessionError(self.session.source_refused)

    # ---- On the session's thread ----

    def _stop(self) -> None:
        self._restart = False
        self.session.stop()

    def _start_again(self) -> None:
        self.session.stop()
        self.session.unlock()
        self.session.recover()
        self._page_lost, self._restart = False, True

    def _await_touch(self, order: TouchOrder) -> None:
        if not order.look(self.session.skin, time.monotonic()):
            return
        self._tell(order.told)
        if order.marked is None:
            self._order = None
            self.session.forget_times()
            self._start_again()

    def _work(self) -> None:
        try:
            if self._order is not None:
                self._tell(self._order.told)
            while not self._closing.is_set():
                while self._obey():
                    pass
                if self._order is not None:
                    self._restart = False
                    self._await_touch(self._order)
                if self._restart and self.session.state is SafetyState.ready:
                    self.session.start()
                    self._restart = False
                self.session.run(SLICE_S)
                self._health.stepped(time.monotonic_ns())
                self.look_for_page()
                self._measure_rates()
                self._snapshot = self._take()
        finally:
            try:
                self.session.end()
            finally:
                self._health.close()

    def _measure_rates(self) -> None:
        now, before = time.monotonic(), self._counted
        if now - before[0] < RATE_WINDOW_S:
            return
        counts = self.session.connected_skin.statistics()
        gone = now - before[0]
        self._counted = (now, counts)
        self._goal = self._look_at_goal()
        self._held_back = self._tell_what_holds_back()
        self._rates = {
            "frames_per_s": (counts["frames"] - before[1]["frames"]) / gone,
            "datagrams_per_s": (counts["accepted"] - before[1]["accepted"]) / gone,
            "driver_cpu_percent": (counts["thread_cpu_ns"] - before[1]["thread_cpu_ns"]) * 1e-7 / gone,
            "frames_lost": float(counts["frames_missing"]),
        }

    def _tell_what_holds_back(self) -> str:
        session = self.session
        found = interventions_told(session.controller.intervention_counts, session.robot.joint_names)
        slow = "" if session.confirmed else "slow until confirmed: type c in the terminal"
        slider = "" if session.speed.slider >= 1.0 else f"the robot's speed slider is at {session.speed.slider:.0%}"
        latency = session.latency()
        command = latency.get("command_p99_s")
        timed = "" if command is None else f"state to command {command * 1e3:.1f} ms (p99)"
        return "; ".join(part for part in (session.closed_ports(), slow, slider, timed, found) if part)

    def _take(self) -> Snapshot:
        session = self.session
        why = "the page was lost" if self._page_lost else session.why_not_running()
        order = self._order
        return Snapshot(
            marked=None if order is None else order.marked,
            time_s=time.monotonic() - self._began_s,
            joint_position=np.array(session.joints.position),
            skin=SkinReading.of(session.skin, time.monotonic_ns(), self._health.told()),
            behaviour=session.behaviour,
            interface=session.interface,
            mode=session.mode,
            skin_on=session.skin_on,
            source_refused=session.source_refused,
            goal=self._goal,
            held_back=self._held_back,
            controller_state=session.state.name,
            stop_reason=order.told if order else "" if session.state is SafetyState.running else why,
            statistics=dict(self._rates),
        )
