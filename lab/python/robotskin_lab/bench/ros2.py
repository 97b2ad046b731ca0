# SPDX-License-Identifier: Apache-2.0
"""ROS 2 without ROS: a skin's load through driver, tapes and DDS to an independent stack in a process of its own."""

from __future__ import annotations

import dataclasses
import multiprocessing
import sys
import time
from multiprocessing.connection import Connection
from typing import Annotated, Any

import numpy as np
import typer

from robotskin import robots
from robotskin.errors import RobotskinError
from robotskin.record import Recorder
from robotskin.sharing.follower import Follower
from robotskin.skin import SkinState
from robotskin_lab.bench.progress import tell
from robotskin_lab.bench.record_load import TICK_NS, Rig

ROBOT = "talos"
TOPIC, TYPE = "/skin/state", "robotskin_msgs/msg/SkinState"
SETTLE_S = 1.0
SWITCH_S = 0.0005
MATCHED_WITHIN_S = 30.0


def run(
    *,
    seed: int = 1,
    seconds: Annotated[float, typer.Option(help="Of the load of the largest skin.")] = 10.0,
    short: Annotated[bool, typer.Option("--short", help="A tenth of it.")] = False,
    domain: Annotated[int, typer.Option(help="Of DDS.")] = 77,
) -> dict[str, Any]:
    """1260 cells at 250 Hz to rosless on the loopback: what is lost, and how long it takes from the skin's read on.

    Needs cyclonedds, rosbags and rosless. Times are from the read of the skin in the control thread to the foreign
    program's having the message, on one clock.
    """
    try:
        import rosless  # noqa: F401

        from robotskin.sharing.ros2_bridge import Ros2Bridge  # noqa: F401
    except ImportError as error:
        raise RobotskinError(f"bench ros2 needs {error.name}: pip install cyclonedds rosbags rosless") from error
    seconds = seconds / 10 if short else seconds
    # The load is made in Python here, by a thread that hardly ever waits; on a robot it comes in by threads of C++.
    switch_s = sys.getswitchinterval()
    sys.setswitchinterval(SWITCH_S)
    try:
        return _loaded(seed, seconds, domain)
    finally:
        sys.setswitchinterval(switch_s)


def _loaded(seed: int, seconds: float, domain: int) -> dict[str, Any]:
    from robotskin.sharing.ros2_bridge import Ros2Bridge

    rig = Rig.of(ROBOT, seed)
    state = SkinState(len(rig.layout))
    bridge = Ros2Bridge(robots.load(ROBOT), rig.layout, domain)
    ours, theirs = multiprocessing.get_context("spawn").Pipe()
    listener = multiprocessing.get_context("spawn").Process(target=listen, args=(theirs, domain), daemon=True)
    listener.start()
    tell("ros2: the foreign stack comes")
    ours.recv()
    ends = time.monotonic() + MATCHED_WITHIN_S
    while not bridge.readers[TOPIC]:
        if time.monotonic() > ends:
            raise RobotskinError(f"bench ros2: no reader of {TOPIC} on domain {domain} within {MATCHED_WITHIN_S:g} s")
        time.sleep(0.01)
    reads_ns: dict[int, int] = {}
    shown = Timed(bridge)
    follower = Follower(rig.layout, [shown])
    with Recorder(None, rig, followers=[follower]) as recorder:
        tell("ros2: the load")
        began = time.monotonic()
        for tick in range(round(seconds * 1e3)):
            rig.tick(state)
            reads_ns[rig.now_ns] = time.monotonic_ns()
            ahead_s = (tick + 1) * TICK_NS * 1e-9 - (time.monotonic() - began)
            if ahead_s > 0:
                time.sleep(ahead_s)
        took_s = time.monotonic() - began
        recorder.drain()
        time.sleep(SETTLE_S)
        offset_ns = follower.since_1970_ns or 0
        used_s = time.clock_gettime(follower.clock_id)
        failure, dropped = follower.failure, follower.dropped
    if failure is not None:
        raise failure
    ours.send("end")
    heard: list[tuple[int, int]] = ours.recv()
    listener.join()
    tell("")
    stamps = {stamp_ns - offset_ns: came_ns for stamp_ns, came_ns in heard}
    from_read_ms = np.array([came - reads_ns[stamp] for stamp, came in stamps.items()]) * 1e-6
    sent_ms = np.array([stamps[stamp] - at for stamp, at in shown.shown_ns.items() if stamp in stamps]) * 1e-6
    return {
        "cells": len(rig.layout),
        "ros2_sent": bridge.sent,
        "ros2_rate_hz": bridge.sent / took_s,
        "ros2_lost": bridge.sent - len(stamps),
        "ros2_blocks_dropped": dropped,
        "ros2_latency_p50_ms": float(np.percentile(sent_ms, 50)),
        "ros2_latency_p99_ms": float(np.percentile(sent_ms, 99)),
        "ros2_from_read_p50_ms": float(np.percentile(from_read_ms, 50)),
        "ros2_from_read_p99_ms": float(np.percentile(from_read_ms, 99)),
        "ros2_cpu_percent": 100 * used_s / took_s,
        "load_realtime_factor": seconds / took_s,
    }


@dataclasses.dataclass
class Timed:
    """A bridge, and when each moment was handed to it, by the skin's clock."""

    bridge: Any
    shown_ns: dict[int, int] = dataclasses.field(default_factory=dict)

    @property
    def period_s(self) -> float:
        """Of the bridge."""
        return float(self.bridge.period_s)

    def show(self, frame: Any, stamp_ns: int) -> None:
        """Note the time, and hand on."""
        self.shown_ns[frame.time_ns] = time.monotonic_ns()
        self.bridge.show(frame, stamp_ns)

    def tell_network(self, topology: Any, statistics: Any, stamp_ns: int) -> None:
        """Hand on."""
        self.bridge.tell_network(topology, statistics, stamp_ns)

    def close(self) -> None:
        """Keep the topics until the listener has ended."""


def listen(pipe: Connection, domain: int) -> None:
    """In a process of its own: take every message, note (its stamp, when it came) in nanoseconds, tell them."""
    import rosless

    from robotskin.ros2.message_types import own_definitions

    rosless.register_type(TYPE, own_definitions()[TYPE])
    subscription = rosless.Node(domain).subscribe(TOPIC, TYPE, wait=30.0, reliability="reliable", history="keep_all")
    pipe.send("ready")
    heard = []
    while not pipe.poll():
        message = subscription.read(timeout=0.05)
        if message is not None and not isinstance(message, bytes):
            came_ns = time.monotonic_ns()
            heard.append((message.header.stamp.sec * 10**9 + message.header.stamp.nanosec, came_ns))
    pipe.send(heard)
