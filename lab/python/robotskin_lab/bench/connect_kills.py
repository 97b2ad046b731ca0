# SPDX-License-Identifier: Apache-2.0
"""Kills of what moves a robot, or holds its skin or page: how long it goes on moving, and what is started again."""

from __future__ import annotations

import tempfile
import time
from pathlib import Path

import numpy as np

from robotskin.rehearsal import Asked, Look
from robotskin.robots import load
from robotskin.robots.gains import gains_of
from robotskin_lab.bench.connect_faults import BRAKE_S, Figures, port_kills_of, side_by_side
from robotskin_lab.bench.connected_processes import ROBOT, ConnectedProcesses
from robotskin_lab.bench.progress import tell

KINDS = ("port", "unit", "session", "page")
SCRIPT_DECELERATION = 10.0
"""rad/s² with which the UR's script stops."""
MOVING_RAD_S = 0.1
FORCE_N = (8.0, 15.0)
REST_S = 0.4
"""A robot that has not moved for so long is at rest."""
WITHIN_S = 30.0
WORST = RESTS, BEYOND = "rest_worst_s", "beyond_worst_s"
AGAIN_S = 180.0
"""In which a robot must move again once what was killed has been started."""


def kills_of(hosts: list[str], seed: int, count: int) -> Figures:
    """Kills of each kind in turn, in an order drawn from the seed; those of ports are shared among the hosts.

    `…_rest_worst_s` is until rest; `…_beyond_worst_s` is what of it is more than the robot's own stop from its speed.
    """
    random = np.random.default_rng(seed)
    drawn = [KINDS[at % len(KINDS)] for at in range(count)]
    random.shuffle(drawn)
    ports, others = drawn.count("port"), [kind for kind in drawn if kind != "port"]
    figures: Figures = {"kills": float(count), "kill_hangs": 0.0, "kill_others_ended": 0.0, "kill_standstills": 0.0}
    if others:
        with (
            tempfile.TemporaryDirectory() as folder,
            ConnectedProcesses(hosts[0], Path(folder), seed) as processes,
        ):
            for name, value in _kills_of_connected(processes, others, random).items():
                figures[name] = figures.get(name, 0.0) + value
    if ports:
        found = side_by_side(port_kills_of, hosts, seed, ports)
        figures["kill_hangs"] += found["kill_hangs"]
        figures |= _of("port", [(found["kill_rest_worst_s"], found["kill_rest_worst_s"] - BRAKE_S)] * ports)
    worst = {name: max(value for figure, value in figures.items() if figure.endswith(name)) for name in WORST}
    return figures | {"kill_rest_worst_s": worst[RESTS], "kill_rest_beyond_stop_s": worst[BEYOND]}


def _kills_of_connected(processes: ConnectedProcesses, kinds: list[str], random: np.random.Generator) -> Figures:
    robot = load(ROBOT)
    guard = np.array(gains_of(robot).guard_limits(robot.core).stop_deceleration)
    found: dict[str, list[tuple[float, float]]] = {kind: [] for kind in kinds}
    hangs = ended = standstills = 0
    for number, kind in enumerate(kinds):
        tell(f"kill {number} of {len(kinds)}: {kind}")
        if not _moving(processes, random):
            standstills += 1
        processes.kill(kind)
        ends = time.monotonic() + WITHIN_S
        while processes.arm.ask(Look(("rested_s",)))[0] < REST_S and time.monotonic() < ends:
            time.sleep(0.02)
        hangs += time.monotonic() >= ends
        moving_s, fastest = processes.arm.ask(Look(("moving_s", "fastest")))
        own_stop_s = float((fastest / (SCRIPT_DECELERATION if kind == "session" else guard)).max())
        found[kind].append((moving_s, moving_s - own_stop_s))
        fallen = processes.ended()
        ended += len(fallen)
        for name in fallen:
            processes.kill(name)
        for name in [*fallen, kind]:
            if name == "session":
                # Each session holds the posture where it begins: hundreds of touches from one side would fold the arm.
                processes.arm.ask(Asked("go_home"))
            processes.start(name)
    standstills += not _moving(processes, random)
    figures = {"kill_hangs": float(hangs), "kill_others_ended": float(ended), "kill_standstills": float(standstills)}
    for kind, rests in found.items():
        figures |= _of(kind, rests)
    return figures


def _moving(processes: ConnectedProcesses, random: np.random.Generator) -> bool:
    """Touch cells until the robot moves, and go on for a moment; whether it does, which is noted from here on."""
    speed = 0.0
    while speed < MOVING_RAD_S:
        cell, force_n = int(random.integers(processes.cells)), float(random.uniform(*FORCE_N))
        moves = processes.moves(cell, force_n, MOVING_RAD_S, AGAIN_S)
        time.sleep(float(random.uniform(0.0, 0.05)))
        speed = processes.arm.ask(Asked("mark"))
        if not moves:
            return False
    return True


def _of(kind: str, rests: list[tuple[float, float]]) -> Figures:
    """Of times until rest, and of what is beyond the own stop."""
    return {
        f"kill_{kind}_count": float(len(rests)),
        f"kill_{kind}_rest_worst_s": max(rest for rest, _ in rests),
        f"kill_{kind}_beyond_worst_s": max(0.0, *(beyond for _, beyond in rests)),
    }
