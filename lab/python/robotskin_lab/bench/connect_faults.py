# SPDX-License-Identifier: Apache-2.0
"""Faults of a controller while the UR port moves its robot, and kills of the process that does."""

from __future__ import annotations

import os
import signal
import struct
import threading
import time
from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor

import numpy as np

from robotskin.model import CommandMode, JointCommand, JointState
from robotskin.rehearsal import Asked, ControllerSettings, Look, Process, controller
from robotskin.rehearsal.rtde import WRONG_RECIPES
from robotskin.rehearsal.ur_controller import REST_RAD_S, SAFETY_BITS
from robotskin.robots import load
from robotskin.ur import UrCondition, UrPort
from robotskin_lab.bench.progress import tell

STOPS = tuple(name for name in SAFETY_BITS if name != "normal")
FAULTS = ("cut", "stall", "half", "noise", "version", "recipes", "scaled", *STOPS)
SPEED = 0.3
CYCLE_S = 0.002
BRAKE_S = SPEED / 10.0
REST_WITHIN = 100
"""Cycles of the controller."""
HANG_S = 20.0
"""After which a port that has not come back hangs."""
FASTEST_SHARE = 1.5
"""Of the speed commanded: a joint that was ever faster has left the limits."""
OTHER_VERSION = (5, 11, 0, 0)
WITHIN_S = 30.0

Figures = dict[str, float]
SUMMED = ("faults", "hangs", "connections", "moving_after_stop", "version_taken", "recipe_taken", "violations")
Part = Callable[[str, np.random.Generator, int], Figures]


def side_by_side(part: Part, hosts: list[str], seed: int, count: int) -> Figures:
    """A part's `count` shared among controllers at `hosts`, each in a thread; sums and worst of what it found."""
    shares = [count // len(hosts) + (index < count % len(hosts)) for index in range(len(hosts))]
    busy = [
        (host, np.random.default_rng([seed, index]), share)
        for index, (host, share) in enumerate(zip(hosts, shares, strict=True))
        if share > 0
    ]
    with ThreadPoolExecutor(len(hosts)) as pool:
        found = list(pool.map(lambda job: part(*job), busy))
    figures: Figures = {}
    for name in found[0] if found else ():
        values = [one[name] for one in found]
        figures[name] = sum(values) if name.endswith(SUMMED) else max(values)
    return figures


class _Mover:
    """Commands a speed of the first joint there and back, on a thread of its own, whenever the robot takes it."""

    def __init__(self, port: UrPort) -> None:
        self.port, self.ending, self.sent = port, threading.Event(), 0
        self.thread = threading.Thread(target=self._run)
        self.thread.start()

    def _run(self) -> None:
        state, command = JointState(6), JointCommand(CommandMode.velocity, 6)
        while not self.ending.is_set():
            self.port.read(state)
            command.value = np.array([SPEED if time.monotonic() % 2 < 1 else -SPEED, 0, 0, 0, 0, 0])
            self.sent += self.port.write(command).name == "ok"
            time.sleep(0.004)

    def close(self) -> None:
        self.ending.set()
        self.thread.join()


def faults_of(host: str, random: np.random.Generator, count: int) -> Figures:
    """Faults of a controller at an address while its robot is moved; after each the port must come back by itself."""
    with controller("ur5", host) as arm:
        port = UrPort(load("ur5").core, host, "UR5", within_s=WITHIN_S, realtime=True)
        mover = _Mover(port)
        try:
            return _faults(arm, port, mover, random, count)
        finally:
            mover.close()
            port.close()


def _faults(arm: Process, port: UrPort, mover: _Mover, random: np.random.Generator, count: int) -> Figures:
    hangs, moving, versions, recipes, cycles, longest_back_s = 0, 0, 0, 0, 0, 0.0
    drawn: list[str] = []
    for number in range(count):
        if number % 50 == 0:
            tell(f"fault {number} of {count}")
        time.sleep(random.uniform(0.0, 0.05))
        if not drawn:  # of every kind as many
            drawn = [str(one) for one in random.permutation(FAULTS)]
        fault = drawn.pop()
        if fault in STOPS:
            steps = _stop(arm, fault)
            moving += steps is None
            cycles = max(cycles, steps or 0)
        elif fault == "version":
            arm.ask(Asked("update", (OTHER_VERSION,)))
            versions += _takes_it(port)
            arm.ask(Asked("update", (ControllerSettings().version,)))
        elif fault == "recipes":
            arm.ask(Asked("spoil", (str(random.choice(WRONG_RECIPES)),)))
            recipes += _takes_it(port)
            arm.ask(Asked("spoil", ("",)))
        elif fault == "scaled":
            _scale(arm, random)
        else:
            _break(arm, fault, random)
        began, sent = time.monotonic(), mover.sent
        while (port.condition is not UrCondition.ready or mover.sent == sent) and time.monotonic() < began + HANG_S:
            time.sleep(0.002)
        gone = time.monotonic() - began
        hangs += gone >= HANG_S
        longest_back_s = max(longest_back_s, gone)
    fastest = float(arm.ask(Look(("fastest_rad_s",)))[0])
    return {
        "ur_faults": float(count),
        "ur_hangs": float(hangs),
        "ur_moving_after_stop": float(moving),
        "ur_cycles_to_stop_most": float(arm.ask(Look(("cycles_to_stop",)))[0]),
        "ur_cycles_resumed_most": float(arm.ask(Look(("cycles_resumed",)))[0]),
        "ur_cycles_to_rest_most": float(cycles),
        "ur_version_taken": float(versions),
        "ur_recipe_taken": float(recipes),
        "ur_limit_violations": float(fastest > FASTEST_SHARE * SPEED),
        "ur_longest_back_s": longest_back_s,
        "ur_fastest_rad_s": fastest,
        "ur_speed_commanded_rad_s": SPEED,
        "ur_connections": float(port.connections),
    }


def _stop(arm: Process, name: str) -> int | None:
    """Cycles of the controller from a stop by its safety system to rest; None: it still moves after `REST_WITHIN`."""
    arm.ask(Asked("trip", (name,)))
    began = arm.ask(Look(("steps",)))[0]
    found, ended = None, False
    while found is None and not ended:
        time.sleep(0.002)
        # Whether the time is up is asked first: this process may be held up in between, and the arm not.
        ended = arm.ask(Look(("steps",)))[0] >= began + REST_WITHIN
        found = arm.ask(Look(("steps_to_rest",)))[0]
    arm.ask(Asked("trip", ("normal",)))
    return found if found is not None and found <= REST_WITHIN else None


def _takes_it(port: UrPort) -> bool:
    """Whether the port takes a controller that has just come back otherwise than it was."""
    ends = time.monotonic() + 0.4
    while port.condition is UrCondition.ready and time.monotonic() < ends:
        time.sleep(0.002)
    time.sleep(0.25)
    return port.condition is UrCondition.ready


def _scale(arm: Process, random: np.random.Generator) -> None:
    """A hand moves the speed slider about, sometimes to 0; at the end it stands where it was."""
    for _ in range(int(random.integers(1, 5))):
        arm.ask(Asked("slide", (float(random.choice([0.0, random.uniform(0.0, 1.0)])),)))
        time.sleep(random.uniform(0.0, 0.1))
    arm.ask(Asked("slide", (1.0,)))


def _break(arm: Process, fault: str, random: np.random.Generator) -> None:
    if fault == "stall":
        os.kill(arm.pid, signal.SIGSTOP)
        time.sleep(random.uniform(0.02, 0.3))
        os.kill(arm.pid, signal.SIGCONT)
    elif fault == "cut":
        arm.ask(Asked("cut"))
    elif fault == "half":
        arm.ask(Asked("corrupt", (struct.pack(">HB", 400, ord("U")) + bytes(20),)))
    else:
        arm.ask(Asked("corrupt", (random.bytes(int(random.integers(1, 400))),)))


class Commander:
    """Moves the robot at an address, in a process of its own."""

    def __init__(self, host: str, speed: float = SPEED) -> None:
        self._port = UrPort(load("ur5").core, host, "UR5", within_s=WITHIN_S)
        self._state, self._command = JointState(6), JointCommand(CommandMode.velocity, 6)
        self._command.value = np.array([speed, 0, 0, 0, 0, 0])

    def run(self, seconds: float) -> None:
        """Command for a time."""
        ends = time.monotonic() + seconds
        while time.monotonic() < ends:
            self._port.read(self._state)
            self._port.write(self._command)
            time.sleep(0.002)

    def close(self) -> None:
        """Stop."""
        self._port.close()


def port_kills_of(host: str, random: np.random.Generator, count: int) -> Figures:
    """Kills of a process that holds the port alone and moves the robot.

    Times are the controller's, from the last command that reached it.
    """
    worst_s, hangs = 0.0, 0
    with controller("ur5", host) as arm:
        for number in range(count):
            if number % 20 == 0:
                tell(f"kill {number} of {count}")
            commander = Process(Commander, preloaded=__name__, host=host, speed=SPEED if number % 2 else -SPEED)
            ends = time.monotonic() + WITHIN_S
            while np.abs(arm.ask(Look(("arm.velocity",)))[0]).max() < SPEED / 2 and time.monotonic() < ends:
                time.sleep(0.005)
            time.sleep(random.uniform(0.0, 0.1))
            commander.kill()
            ends = time.monotonic() + WITHIN_S
            while np.abs(arm.ask(Look(("arm.velocity",)))[0]).max() > REST_RAD_S and time.monotonic() < ends:
                time.sleep(0.002)
            hangs += time.monotonic() >= ends
        worst_s = arm.ask(Look(("cycles_to_rest",)))[0] * CYCLE_S
    return {"kill_hangs": float(hangs), "kill_rest_worst_s": worst_s}
