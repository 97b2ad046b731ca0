# SPDX-License-Identifier: Apache-2.0
"""A connected robot on a thread of its own, for the page: the view of a simulated session, without its world."""

from __future__ import annotations

import contextlib
import queue
import threading
import time
from collections.abc import Callable

import numpy as np
from numpy.typing import NDArray

from robotskin.choices import member
from robotskin.connecting import ConnectedRobot
from robotskin.cycle import SafetyState
from robotskin.errors import InputError, UnknownNameError
from robotskin.firmware import CellMode
from robotskin.model import CommandMode
from robotskin.session import SessionError
from robotskin.session.goals import GoalWatch, reference_of
from robotskin.session.reasons import interventions_told
from robotskin.viewer.session_view import Floats, Goal, RobotView, SkinReading, Snapshot, Solid

__all__ = ["ConnectedSession"]

SLICE_S = 0.016
RATE_WINDOW_S = 0.5
PAGE_LOST_S = 1.0
"""Without a browser, after the first one came, until the robot stops."""
TOUCH_IT = "there is no simulated hand: touch the skin itself"


class ConnectedSession:
    """Runs a `ConnectedRobot` that has begun until `close`, as a `robotskin.viewer.session_view.SessionView`."""

    network = None
    solids: tuple[Solid, ...] = ()

    def __init__(self, session: ConnectedRobot) -> None:
        self.session = session
        self.robot: RobotView = session.robot
        self.layout = session.layout
        self.title = f"{session.robot.name}, {len(session.layout)} cells, connected"
        self.failure: BaseException | None = None
        self.terminal: dict[str, Callable[[], None]] = {"c": self.confirm, "s": self.stop, "g": self.reset}
        """What one letter in the terminal does."""
        self._requests: queue.SimpleQueue[Callable[[], object]] = queue.SimpleQueue()
        self._lookers: Callable[[], int] | None = None
        self._looked_s: float | None = None
        self._page_lost = False
        self._restart = False
        self._began_s = time.monotonic()
        self._rates: dict[str, float] = {}
        self._counted = (self._began_s, session.driver.statistics())
        self.goals = GoalWatch(session, None)
        self._snapshot = self._take()
        self._closing = threading.Event()
        self._thread = threading.Thread(target=self._run, name="connected session")
        self._thread.start()

    def __enter__(self) -> ConnectedSession:
        return self

    def __exit__(self, *_: object) -> None:
        self.close()

    def close(self) -> None:
        """Bring the robot to rest and end the thread."""
        self._closing.set()
        self._thread.join()

    def watch_page(self, lookers: Callable[[], int]) -> None:
        """Stop the robot where all browsers that looked are gone for a second; `lookers` counts them."""
        self._lookers = lookers

    # ---- What a page or the terminal asks ----

    def snapshot(self) -> Snapshot:
        """The latest moment."""
        return self._snapshot

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

    def set_interface(self, interface: str) -> None:
        """Command the robot through another interface."""
        chosen = member("interface", CommandMode, interface)
        if not self.session.port.offers(chosen):
            raise SessionError(f"interface {interface}: this robot does not offer it")
        self._ask(lambda: self.session.set_interface(chosen))

    @property
    def behaviours(self) -> dict[str, str]:
        """What the robot can be told to do, and what each means."""
        return self.session.behaviours

    def set_behaviour(self, behaviour: str) -> None:
        """Do something else; the torque does not jump."""
        if behaviour not in self.behaviours:
            raise UnknownNameError("behaviour", behaviour, self.behaviours)
        self._ask(lambda: self.session.set_behaviour(behaviour))

    def set_goal(self, goal: Floats) -> None:
        """Go there: (n,) rad or m of the joints, or (3,) metres of the hand. Raises InputError."""
        place = np.array(goal, dtype=float)
        reference = reference_of(self.session, place)
        self._ask(lambda: self._go(place, reference))

    def set_mode(self, mode: CellMode | str) -> None:
        """Let the cells send in another mode."""
        chosen = member("mode", CellMode, mode)
        self._ask(lambda: self.session.set_mode(chosen))

    def set_source(self, source: str) -> None:
        """Refused but for the host: these cells have not been told how to compute torques."""
        if source != "host":
            raise SessionError(self.session.source_refused)

    def set_skin(self, on: bool) -> None:
        """Let the skin move the robot, or not."""
        self._ask(lambda: self.session.set_skin(on))

    def _ask(self, request: Callable[[], object]) -> None:
        if self.failure is not None:
            raise SessionError(f"the session has ended: {self.failure}")
        self._requests.put(request)

    # ---- On the session's thread ----

    def _go(self, goal: NDArray[np.float64], reference: NDArray[np.float64]) -> None:
        # The behaviour may have changed since the page asked: then the page shows the goal that it has.
        with contextlib.suppress(InputError):
            self.session.controller.set_reference(reference)
            self.goals.given(goal)

    def _stop(self) -> None:
        self._restart = False
        self.session.stop()

    def _start_again(self) -> None:
        self.session.stop()
        self._page_lost, self._restart = False, True

    def _run(self) -> None:
        try:
            while not self._closing.is_set():
                while not self._requests.empty():
                    self._requests.get()()
                if self._restart and self.session.state is SafetyState.ready:
                    self.session.start()
                    self._restart = False
                self.session.run(SLICE_S)
                self._look_for_page()
                self._measure_rates()
                self._snapshot = self._take()
        except BaseException as failure:
            self.failure = failure
            raise
        finally:
            self.session.end()

    def _look_for_page(self) -> None:
        if self._lookers is None:
            return
        now = time.monotonic()
        if self._lookers() > 0:
            self._looked_s = now
        elif self._looked_s is not None and now - self._looked_s > PAGE_LOST_S:
            # SAFETY: it cannot be stopped by the page any more.
            self._looked_s, self._page_lost = None, True
            self.session.stop()

    def _measure_rates(self) -> None:
        now, before = time.monotonic(), self._counted
        if now - before[0] < RATE_WINDOW_S:
            return
        counts = self.session.driver.statistics()
        gone = now - before[0]
        self._counted = (now, counts)
        self._rates = {
            "frames_per_s": (counts["frames"] - before[1]["frames"]) / gone,
            "datagrams_per_s": (counts["accepted"] - before[1]["accepted"]) / gone,
            "driver_cpu_percent": (counts["thread_cpu_ns"] - before[1]["thread_cpu_ns"]) * 1e-7 / gone,
            "frames_lost": float(counts["frames_missing"]),
        }

    def _goal(self) -> Goal | None:
        kind, at, left, told = self.goals.look()
        return Goal(kind, at, self.goals.goal is not None, left, told) if kind and at is not None else None

    def _held_back(self) -> str:
        session = self.session
        found = interventions_told(session.controller.intervention_counts, session.robot.joint_names)
        slow = "" if session.confirmed else "slow until confirmed: type c in the terminal"
        latency = session.latency()
        command = latency.get("command_p99_s")
        timed = "" if command is None else f"state to command {command * 1e3:.1f} ms (p99)"
        return "; ".join(part for part in (slow, timed, found) if part)

    def _take(self) -> Snapshot:
        session = self.session
        why = "the page was lost" if self._page_lost else session.why_not_running()
        return Snapshot(
            time_s=time.monotonic() - self._began_s,
            joint_position=np.array(session.joints.position),
            skin=self._reading(),
            behaviour=session.behaviour,
            interface=session.interface,
            mode=session.mode,
            skin_on=session.skin_on,
            source_refused=session.source_refused,
            goal=self._goal(),
            held_back=self._held_back(),
            controller_state=session.state.name,
            stop_reason="" if session.state is SafetyState.running else why,
            statistics=dict(self._rates),
        )

    def _reading(self) -> SkinReading:
        skin = self.session.skin
        stamp_ns = np.array(skin.stamp_ns)
        return SkinReading(
            normal_force=np.array(skin.normal_force),
            proximity=np.array(skin.proximity),
            distance=np.array(skin.distance),
            acceleration=np.array(skin.acceleration),
            temperature=np.array(skin.temperature),
            health=np.array(skin.health),
            age_s=np.where(stamp_ns > 0, (time.monotonic_ns() - stamp_ns) * 1e-9, np.inf),
        )
