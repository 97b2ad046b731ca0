# SPDX-License-Identifier: Apache-2.0
"""`robotskin bench session`: how fast a session of a whole skin runs, and what takes its time.

Real times: on a machine that does nothing else.
"""

from __future__ import annotations

import time
from typing import Annotated, Any

import numpy as np
import typer

from robotskin.errors import UnknownNameError
from robotskin.layout import finished
from robotskin.live.live_session import LiveSession
from robotskin.robots.gains import robot_with_gains
from robotskin.session import PERIOD_S, Session
from robotskin.viewer.page import FRAMES_PER_S, Page
from robotskin.world.ideal import ideal_world
from robotskin_lab.bench.count import Count
from robotskin_lab.bench.progress import tell, tell_step

PARTS = ("ideal", "imperfect", "page", "threads")
ONE_PIECE = 0
"""Threads of a network that is run in one piece: how it was before its groups were run apart."""
SLICE_S = 0.25
"""Two sessions take turns in slices of so much virtual time, so that both have the same machine."""
PUSH_N = 8.0
THREADS = (1, 2, 4)
DRAWN_FRAMES = 30


def run(
    *,
    seed: int = 1,
    robot: str = "talos",
    seconds: Annotated[float, typer.Option(min=SLICE_S)] = 3.0,
    threads: Count = 2,
    parts: str = ",".join(PARTS),
) -> dict[str, Any]:
    """Run a session of this robot in its whole skin at the clock rate, pushed all the time.

    session_realtime_CELLS: virtual over real seconds, through UDP on loopback. network_s_per_s, body_s_per_s:
    real seconds that each takes of a virtual one; control_s_per_s, driver_s_per_s: processor time of these;
    processor_s_per_s: of all threads; rest_s_per_s: real time that none of them took.
    over_before: how many times as fast as in one piece, in runs that take turns. imperfect: with all imperfections, and
    cells that take their time; ideal: in the ideal world, where the names of the same figures end in `_ideal`.
    page_s_per_s: of drawing for one browser.
    equal_hashes: the same run, to the byte, with one, two and four threads.

    Args:
        seed: of the worlds.
        robot: with a finished skin.
        seconds: virtual, of each measurement.
        threads: that run the groups of section units.
        parts: with commas between: ideal, imperfect, page, threads.

    Raises:
        UnknownNameError: no such part or robot.
    """
    asked = parts.split(",")
    for part in asked:
        if part not in PARTS:
            raise UnknownNameError("part", part, PARTS)
    figures: dict[str, Any] = {"cells": float(len(finished(robot))), "threads": float(threads)}
    for part, suffix in (("ideal", "_ideal"), ("imperfect", "")):
        if part in asked:
            with ideal_world(part == "ideal"):
                found = speed_figures(robot, seed, seconds, threads)
            figures |= {f"{name}{suffix}": value for name, value in found.items()}
    if "page" in asked:
        figures |= page_figures(robot, seed, threads)
    if "threads" in asked:
        figures |= thread_figures(robot, seed, seconds)
    tell("")
    return figures


def session_of(robot: str, seed: int, threads: int, *, udp: bool = True) -> Session:
    """A session of this robot in its finished skin, not booted."""
    ready = robot_with_gains(robot)
    layout = finished(robot)
    link = "udp" if udp else "in process"
    return Session(ready.robot, layout, seed=seed, gains=ready.gains, link=link, threads=threads)  # type: ignore[arg-type]


class Timed:
    """A pushed session, and the real time that it took."""

    def __init__(self, session: Session, seed: int) -> None:
        self.session = session
        session.boot()
        cell = int(np.random.default_rng([seed, 6]).integers(len(session.layout)))
        session.world.push(session.in_world(cell), PUSH_N)
        self.real_s = self.virtual_s = self.processor_s = 0.0
        self._before = self._parts()

    def run(self, seconds: float) -> None:
        """Run for so much virtual time."""
        began, spent = time.perf_counter(), time.process_time()
        self.session.run(seconds)
        self.real_s += time.perf_counter() - began
        self.processor_s += time.process_time() - spent
        self.virtual_s += seconds

    def _parts(self) -> dict[str, float]:
        session, world = self.session, self.session.world
        return {
            "body": world.body_s,
            "network": world.network_s,
            "driver": session.driver_seconds,
            "control": session.control_seconds,
        }

    def per_second(self) -> dict[str, float]:
        """Seconds of a virtual one, by what took them."""
        found = {name: (now - self._before[name]) / self.virtual_s for name, now in self._parts().items()}
        found["rest"] = self.real_s / self.virtual_s - sum(found.values())
        found["processor"] = self.processor_s / self.virtual_s
        return {f"{name}_s_per_s": value for name, value in found.items()}


def speed_figures(robot: str, seed: int, seconds: float, threads: int) -> dict[str, float]:
    """A session in lanes and one in one piece take turns."""
    tell_step(f"{robot}: boots twice")
    apart, together = (Timed(session_of(robot, seed, count), seed) for count in (threads, ONE_PIECE))
    try:
        for _ in range(round(seconds / SLICE_S)):
            for timed in (apart, together):
                timed.run(SLICE_S)
            tell_step(f"{robot}: {apart.virtual_s / apart.real_s:.2f} times real time")
        before = together.per_second()
        return {
            f"session_realtime_{len(apart.session.layout)}": apart.virtual_s / apart.real_s,
            "before_realtime": together.virtual_s / together.real_s,
            "over_before": together.real_s / apart.real_s,
            **apart.per_second(),
            **{f"before_{name}": before[name] for name in ("network_s_per_s", "processor_s_per_s")},
        }
    finally:
        apart.session.shut_down()
        together.session.shut_down()


def page_figures(robot: str, seed: int, threads: int) -> dict[str, float]:
    """Processor time of drawing a pushed session thirty times a second."""
    tell_step(f"{robot}: the page")
    timed = Timed(session_of(robot, seed, threads), seed)
    with LiveSession(timed.session) as live, Page(live, 0) as page:
        began = time.thread_time()
        for frame in range(DRAWN_FRAMES):
            page.draw(live.snapshot(), frame / FRAMES_PER_S)
        spent = time.thread_time() - began
    return {"page_s_per_s": spent * FRAMES_PER_S / DRAWN_FRAMES}


def thread_figures(robot: str, seed: int, seconds: float) -> dict[str, float]:
    """Whether so many threads make the same run."""
    hashes = []
    lanes = 0
    for threads in THREADS:
        tell_step(f"{robot}: {threads} threads")
        session = session_of(robot, seed, threads, udp=False)
        try:
            session.boot()
            session.world.push(session.in_world(0), PUSH_N)
            for _ in range(round(seconds / PERIOD_S)):
                session.step()
            hashes.append((session.world.network.log_hash, session.joints.position.tobytes()))
            lanes = session.world.network.lane_count
        finally:
            session.shut_down()
    return {"equal_hashes": float(len(set(hashes)) == 1), "lanes": float(lanes)}
