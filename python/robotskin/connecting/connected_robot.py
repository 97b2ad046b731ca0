# SPDX-License-Identifier: Apache-2.0
"""The loop over a real robot port and real section units, in real time."""

from __future__ import annotations

import time
from collections.abc import Callable
from copy import deepcopy
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np

from robotskin.choices import member
from robotskin.connecting.connected_skin import ConnectedSkin
from robotskin.connecting.errors import ConnectError
from robotskin.connecting.first_checks import check_before_motion
from robotskin.connecting.speed_cap import UNTRUSTED_SPEED, SpeedCap
from robotskin.connecting.touch_order import TouchOrder
from robotskin.cycle import SafetyState
from robotskin.firmware import PORTS, CellMode
from robotskin.franka import FrankaPort
from robotskin.layout import Layout
from robotskin.loop import PacedLoop
from robotskin.model import RobotPort
from robotskin.robots import Robot
from robotskin.robots.gains import GainSet, gains_of
from robotskin.session import PERIOD_S, SkinnedRobot
from robotskin.ur import UrPort, told

TOLD_MOST = 3
"""Cells of which a line tells."""
SLICE_S = 0.02
"""Of the loop between two looks from outside."""
TARE_S = 0.5
TOUCH_WITHIN_S = 60.0
HOW_TO_SKIP = "--skip-touch leaves this out"
FUSION_SHARE = 0.5
"""Of a period, after which a clock ends the solver: a command that comes late is worse than one that is less exact."""
STOP_S = 2.0
"""In which a robot that is asked to stop must be at rest, before its port is told to stop it."""


class ConnectedRobot(SkinnedRobot):
    """A robot behind its port and a skin behind its section units or of another maker, in one loop.

    Args:
        robot: n joints; layout: of its skin, N cells.
        port: n joints, ready to be read.
        skin: section units, or another maker's skin.
        behaviour, interface, gains, fault_file, …: as of `SkinnedRobot`.
        speed_share: of the velocity limits that may be used until `confirm`.

    Raises ConnectError for a robot that does not stand as its model says, and as `SkinnedRobot`.
    """

    def __init__(
        self,
        robot: Robot,
        layout: Layout,
        port: RobotPort,
        skin: ConnectedSkin,
        behaviour: str = "skin_compliance",
        *,
        gains: GainSet | None = None,
        speed_share: float = UNTRUSTED_SPEED,
        fault_file: str | Path | None = None,
        **options: Any,
    ) -> None:
        self.connected_skin, self.driver, self.reader = skin, skin.driver, skin.reader
        self.seen = check_before_motion(robot, port)
        """What the checks before the first motion found."""
        self.period_s = port.period_s or PERIOD_S
        own = at_period(gains or gains_of(robot), self.period_s)
        ends_s = FUSION_SHARE * self.period_s
        super().__init__(
            robot,
            layout,
            port,
            skin.input,
            behaviour,
            gains=own,
            fault_file=fault_file,
            fusion_ends_s=ends_s,
            **options,
        )
        self.paced = PacedLoop(self.loop, self.period_s, realtime=True)
        self.mode = "clock"
        self.speed = SpeedCap(speed_share)
        """How fast it may be commanded."""
        self._follow_slider(0.0)
        self._settled = False

    # ---- Time ----

    def run(self, seconds: float) -> None:
        """Tick in real time."""
        ends = time.monotonic() + seconds
        while (left := ends - time.monotonic()) > 0:
            self.paced.run(min(left, SLICE_S))
            self._follow_slider(SLICE_S)
            self.fault_file.watch(self.loop.guard, self.controller.task_error)
            self.fault_file.write_at_rest(self.loop.guard, self.controller.cycle, self.robot.joint_names)

    def settle(self) -> None:
        """Take the forces' zero while nothing touches the skin; nothing moves."""
        self.run(0.1)
        self.connected_skin.tare(TARE_S)
        self.run(TARE_S + 0.1)
        self._settled = True

    def check_order(self, order: TouchOrder, tell: Callable[[str], None], within_s: float = TOUCH_WITHIN_S) -> None:
        """Ask for a touch of each marked cell, and tell what was touched; nothing moves.

        Raises ConnectError: no touch in time, or other cells that are touched again and again.
        """
        self.settle()
        tell(order.told)
        ends = time.monotonic() + within_s
        while order.marked is not None:
            if time.monotonic() > ends:
                raise ConnectError(f"skin: no touch of the marked cell within {within_s:.0f} s; {HOW_TO_SKIP}")
            self.run(SLICE_S)
            if not order.look(self.skin, time.monotonic()):
                continue
            tell(order.told)
            if order.refused:
                raise ConnectError(f"skin: {order.found}; is it the layout of this skin? Give it with --layout")
            ends = time.monotonic() + within_s

    def begin(self, within_s: float = 5.0) -> None:
        """Take the forces' zero if that was not done, then start. Raises ConnectError if it does not."""
        if not self._settled:
            self.settle()
        self.start()
        ends = time.monotonic() + within_s
        while self.state not in (SafetyState.running, SafetyState.degraded):
            if time.monotonic() > ends:
                raise ConnectError(f"the robot does not start: {self.why_not_running()}")
            self.run(SLICE_S)
            if self.loop.report.latched:  # it was lost for a moment while it was to start
                self.start()
        self.forget_times()

    def forget_times(self) -> None:
        """Measure latency from now on."""
        self.paced.forget()
        if isinstance(self.port, UrPort):
            self.port.forget_latency()

    def end(self) -> float:
        """Stop smoothly, then by the port; the seconds until rest."""
        began = time.monotonic()
        self.stop()
        try:
            while time.monotonic() - began < STOP_S:
                self.run(SLICE_S)
                if float(np.abs(np.asarray(self.joints.velocity)).max()) < self.loop_rest:
                    break
        finally:
            self.port.stop()
            self.fault_file.write(self.controller.cycle, self.robot.joint_names)
        return time.monotonic() - began

    loop_rest = 0.01
    """rad/s below which the robot is at rest."""

    # ---- What may be asked of it ----

    def confirm(self) -> None:
        """The robot does what it should: let it use its full speed."""
        self.speed.trusted = 1.0

    @property
    def confirmed(self) -> bool:
        """Whether the full speed is allowed."""
        return self.speed.trusted >= 1.0

    def recover(self) -> None:
        """A person starts it anew: what the robot's own safety holds by a reflex is let go. Nothing moves."""
        if isinstance(self.port, FrankaPort):
            self.port.recover()

    def _follow_slider(self, seconds: float) -> None:
        slider = self.port.speed_fraction if isinstance(self.port, UrPort) else 1.0
        self.controller.cycle.request_speed_cap(self.speed.pass_time(seconds, slider, self.interface))

    def set_mode(self, mode: CellMode | str) -> None:
        """Let the cells send at the clock rate, or when something changes. Raises ConnectError where they cannot."""
        if self.driver is None:
            raise ConnectError(f"mode {mode}: another maker's skin sends as it does")
        chosen = member("mode", CellMode, mode)
        for group in sorted({int(group) for group in self.layout.group}):
            self.driver.command("mode", chosen.value, group=group)
        self.mode = str(chosen.name)

    # ---- What is known of it ----

    @property
    def held_by(self) -> str:
        """Why the robot's own safety takes no commands; empty where it does, or where the port cannot tell."""
        if isinstance(self.port, FrankaPort):
            return self.port.condition_told
        if not isinstance(self.port, UrPort) or self.port.condition.name == "ready":
            return ""
        return told(self.port.condition)

    def why_not_running(self) -> str:
        """What the controller waits for, or why it stopped; empty while it runs."""
        own = super().why_not_running()
        lost = "the robot was lost, start it anew" if self.loop.report.latched else ""
        return "; ".join(part for part in (self.held_by, lost, own) if part)

    def closed_ports(self) -> str:
        """Which cells have closed a port for wrong tags, now or lately (docs/protocol.md); empty where none has."""
        if self.driver is None:
            return ""
        told = self.driver.topology()
        closed = np.asarray(told["closed_port"])
        rows = np.flatnonzero(closed)[:TOLD_MOST]
        found = [f"cell {int(told['key'][at]) & 0xFFFF} {_closed(int(closed[at]))}" for at in rows]
        more = np.count_nonzero(closed) - len(found)
        return ", ".join([*found, *([f"{more} more"] if more else [])]) + (" (wrong tags)" if found else "")

    def latency(self) -> dict[str, float]:
        """Seconds: of the loop's parts, as measured since `begin`; what the port cannot tell is left out."""
        alive = self.living
        found = {"worst_gap_s": self.paced.worst_gap_s, "late_ticks": float(self.paced.late_ticks)}
        if alive.any():
            age_ns = time.monotonic_ns() - np.asarray(self.skin.stamp_ns)[alive]
            found["skin_age_median_s"] = float(np.median(age_ns)) * 1e-9
        if isinstance(self.port, UrPort):
            median, p99, worst, count = self.port.latency
            if count:
                found |= {"command_median_s": median, "command_p99_s": p99, "command_worst_s": worst}
        return found


def _closed(place: int) -> str:
    return f"has closed its port {place}" if place <= PORTS else "reads no orders under its own key"


def at_period(gains: GainSet, period_s: float) -> GainSet:
    """The same gains in a cycle of this period."""
    values = deepcopy(gains.values)
    values["resolver"]["period_s"] = period_s
    return replace(gains, values=values)
