# SPDX-License-Identifier: Apache-2.0
"""A session that runs by itself, in real time on a thread of its own, for pages and scripts that look in."""

from __future__ import annotations

import contextlib
import math
import time
from collections import Counter
from collections.abc import Callable

import numpy as np
from numpy.typing import NDArray

from robotskin import firmware
from robotskin.choices import member
from robotskin.cycle import SafetyState, SkinSource
from robotskin.errors import InputError
from robotskin.figures import share_told
from robotskin.live.health_beside import HealthBeside
from robotskin.live.live_robot import RATE_WINDOW_S, LiveRobot
from robotskin.live.network_watch import NetworkWatch
from robotskin.live.session_network import SessionNetwork
from robotskin.session import PERIOD_S, Session, SessionError
from robotskin.session.reasons import interventions_told
from robotskin.simulator import HandTask
from robotskin.viewer.network import grown_tree
from robotskin.viewer.session_view import Ball, SkinReading, Snapshot, Solid, Torques, Touch
from robotskin.world.drawing import piece_colour, piece_mesh

__all__ = ["LiveSession"]

SNAPSHOT_PERIODS = 16
"""Control periods between two snapshots: some sixty a second."""

NETWORK_PERIODS = 4
"""Control periods between two looks at the network, whose repairs take some five milliseconds."""

PERIODS_BEHIND = 200
"""How far the session may fall behind the wall clock before it gives up catching up."""


class LiveSession(LiveRobot):
    """Runs a booted `Session` until `close`; what is asked of it happens between two periods.

    It is a `robotskin.viewer.session_view.SessionView`.
    """

    def __init__(
        self,
        session: Session,
        goal: NDArray[np.float64] | None = None,
        after_step: Callable[[], None] = lambda: None,
    ) -> None:
        """`goal`: the one that the session was given before, (n,) rad or m, or (3,) m of the hand; None: none.

        `after_step`: what an application does after each period, on the session's thread.
        """
        super().__init__(session, session, goal)
        self._after_step = after_step
        self._looks: list[Callable[[], None]] = []
        self.session = session
        self.title = f"{session.robot.name}, {len(session.layout)} cells"
        self.solids = [
            Solid(piece.thing, piece_mesh(piece), piece_colour(piece)) for piece in session.world.scene.pieces
        ]
        world = session.world
        watch = NetworkWatch(world.network, world.layout, lambda: world.time_s)
        self.network = SessionNetwork(watch, self._ask, session.layout, session.world_cells)
        self._touch: Touch | None = None
        self._touch_until_s: float | None = None
        self._restart = self._homing = False
        self._rates: dict[str, float] = {}
        self._counted = self._counts()
        self._held_back = ""
        self._parent = grown_tree(self.layout, session.driver.topology())
        self._health = HealthBeside(session, session.reader)
        self._snapshot = self._take()
        self._begin()

    def remarks(self) -> list[str]:
        """Why commands were changed, and why the last goal is not reached, a sentence each; none where nothing was."""
        found = []
        if self._held_back:
            share = self._rates.get("intervention_share", 0.0)
            found.append(f"the guard changed {share_told(share)} of the commands: {self._held_back}")
        if self._goal is not None and self._goal.told:
            found.append(self._goal.told)
        return found

    @property
    def ill(self) -> dict[str, int]:
        """How many cells are ill, by the names of their kinds."""
        return dict(Counter(one.kind.name for one in self._health.findings))

    def look_with_snapshots(self, look: Callable[[], None]) -> None:
        """Call `look` on the session's thread before each snapshot from now on: it copies what a page shows beside.

        What the session holds changes while other threads read it, and may mean nothing in between.
        """
        self._looks.append(look)

    # ---- What a page asks ----

    def push(self, cell: int, force_n: float, duration_s: float | None = None) -> None:
        """Push a cell against its normal, for `duration_s` seconds or until `release`."""
        self._demand_cell(cell)
        if not 0.0 < force_n < math.inf:
            raise SessionError(f"push with {force_n} N: must be finite and greater than 0")
        self._ask(lambda: self._begin_touch(Touch(cell, force_n=force_n), duration_s))

    def approach(self, cell: int, distance_m: float) -> None:
        """Hold a hand at that distance in front of a cell until `release`."""
        self._demand_cell(cell)
        if not math.isfinite(distance_m):
            raise SessionError(f"approach to {distance_m} m: must be finite")
        self._ask(lambda: self._begin_touch(Touch(cell, distance_m=distance_m), None))

    def release(self) -> None:
        """Take the hand away."""
        self._ask(self._end_touch)

    def set_mode(self, mode: firmware.CellMode | str) -> None:
        """Let the cells send in another mode."""
        chosen = member("mode", firmware.CellMode, mode)
        self._ask(lambda: self.session.set_mode(chosen))

    def set_source(self, source: SkinSource | str) -> None:
        """Let the host or the skin itself compute the torque of the skin task."""
        chosen = member("source", SkinSource, source)
        if chosen is SkinSource.skin and self.session.torques is None:
            raise SessionError("the cells of this session do not compute torques")
        self._ask(lambda: self._set_source(chosen))

    def reset(self) -> None:
        """Take the hand away, go home, and start the controller again if it had stopped."""
        self._ask(self._go_home)

    def _demand_cell(self, cell: int) -> None:
        if not 0 <= cell < len(self.layout):
            raise SessionError(f"cell {cell}: there are cells 0 to {len(self.layout) - 1}")

    # ---- On the session's thread ----

    def _begin_touch(self, touch: Touch, duration_s: float | None) -> None:
        world = self.session.world
        if touch.force_n > 0:
            world.push(self.session.in_world(touch.cell), touch.force_n)
        else:
            world.approach(self.session.in_world(touch.cell), touch.distance_m)
        self._touch = touch
        self._touch_until_s = None if duration_s is None else world.time_s + duration_s

    def _end_touch(self) -> None:
        self.session.world.release()
        self._touch = self._touch_until_s = None

    def _set_source(self, source: SkinSource) -> None:
        # The behaviour may have changed since the page asked: then the page shows the source that it has.
        with contextlib.suppress(InputError):
            self.session.set_source(source)

    def _go_home(self) -> None:
        self._end_touch()
        was_locked = bool(self.session.locked)
        self.session.unlock()
        self.session.controller.request_goal(self.session.home)
        if self.session.state is SafetyState.stopped or was_locked:
            self.session.controller.request_run(False)
            self._restart = True

    def _work(self) -> None:
        try:
            self._run_until_closed()
        finally:
            self._health.close()
            self.session.shut_down()

    def _run_until_closed(self) -> None:
        due = time.monotonic()
        period = 0
        while not self._closing.is_set():
            self._obey_all()
            self.session.step()
            self._after_step()
            self._health.stepped(self.session.world.now_ns)
            period += 1
            if period % NETWORK_PERIODS == 0:
                self.network.look()
            if period % SNAPSHOT_PERIODS == 0:
                self._measure_rates()
                for look in self._looks:
                    look()
                self._snapshot = self._take()
            due = max(due + PERIOD_S, time.monotonic() - PERIODS_BEHIND * PERIOD_S)
            ahead = due - time.monotonic()
            if ahead > PERIOD_S:
                time.sleep(ahead)

    def _obey_all(self) -> None:
        while self._obey():
            pass
        if self._touch_until_s is not None and self.session.world.time_s >= self._touch_until_s:
            self._end_touch()
        if self._restart and self.session.state is SafetyState.ready:
            self.session.start()
            self._restart, self._homing = False, True
        # What is asked of a robot that does not run is dropped.
        if self._homing and self.session.state in (SafetyState.running, SafetyState.degraded):
            self.session.controller.request_goal(self.session.home)
            self._homing = False

    def _counts(self) -> dict[str, float]:
        driver = self.session.driver.statistics()
        return {
            "wall_s": time.monotonic(),
            "virtual_s": self.session.world.time_s,
            "frames": float(driver["frames"]),
            "datagrams": float(driver["accepted"]),
            "driver_s": self.session.driver_seconds,
        }

    def _measure_rates(self) -> None:
        wall_s = time.monotonic() - self._counted["wall_s"]
        if wall_s < RATE_WINDOW_S:
            return
        now = self._counts()
        gone = {name: now[name] - before for name, before in self._counted.items()}
        self._counted = now
        self._parent = grown_tree(self.layout, self.session.driver.topology())
        self._goal = self._look_at_goal()
        controller = self.session.controller
        self._held_back = interventions_told(controller.intervention_counts, self.session.robot.joint_names)
        virtual_s = max(gone["virtual_s"], PERIOD_S)
        self._rates = {
            "realtime_factor": gone["virtual_s"] / wall_s,
            "frames_per_s": gone["frames"] / virtual_s,
            "datagrams_per_s": gone["datagrams"] / virtual_s,
            "driver_cpu_percent": 100.0 * gone["driver_s"] / virtual_s,
            "frames_lost": float(self.session.frames_lost),
            "fallback_ticks": float(controller.cycle.fusion_counts.fallback_ticks),
            "widened_ticks": float(controller.cycle.fusion_counts.widened_ticks),
            "intervention_share": controller.report.interventions / max(1.0, self.session.world.time_s / PERIOD_S),
        }

    def _take(self) -> Snapshot:
        session = self.session
        report = session.controller.report
        stopped = report.state in (SafetyState.stopped, SafetyState.degraded)
        return Snapshot(
            time_s=session.world.time_s,
            joint_position=np.array(session.joints.position),
            skin=SkinReading.of(session.skin, session.world.now_ns, self._health.told()),
            behaviour=session.behaviour,
            interface=session.interface,
            mode=session.mode,
            skin_on=session.skin_on,
            source=session.source,
            source_refused=session.source_refused,
            torques=self._torques(),
            goal=self._goal,
            held_back=self._held_back,
            controller_state=report.state.name,
            stop_reason=session.locked or (report.text if stopped else ""),
            touch=self._touch,
            hands=[
                Ball(np.array(hand.position_m), hand.radius_m)
                for hand in session.world.hands
                if hand.task is not HandTask.parked
            ],
            solids=session.world.base_from_piece() if self.solids else None,
            statistics=dict(self._rates),
            parent=self._parent,
        )

    def _torques(self) -> Torques | None:
        session = self.session
        if session.torques is None:
            return None
        own = session.skin_computed_torque
        return Torques(np.array(session.controller.host_skin_torque), np.array(own.joint), own.fresh, own.cells)
