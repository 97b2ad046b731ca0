# SPDX-License-Identifier: Apache-2.0
"""`robotskin bench connect`: the ports of UR and ROS 2 and the whole loop, against rehearsed controllers."""

from __future__ import annotations

import importlib.util
import os
import signal
import threading
import time
from functools import partial

import numpy as np

from robotskin import choices
from robotskin.connecting import ConnectedRobot
from robotskin.layout import Layout
from robotskin.model import CommandMode, JointCommand, JointState
from robotskin.rehearsal import Asked, Look, Process, controller
from robotskin.rehearsal.ur_controller import SAFETY_BITS
from robotskin.robots import load
from robotskin.session import Session
from robotskin.ur import UrCondition, UrPort
from robotskin_lab.bench.connect_rig import connected, patch_of, stage
from robotskin_lab.bench.progress import tell
from robotskin_lab.bench.touch_answer import TouchAnswer, answer

MODES = choices.INTERFACES
SETTLE_S = 3.0
FAULTS = ("cut", "stall", *(name for name in SAFETY_BITS if name != "normal"))
SPEED = 0.3
REST = 0.01
LIFE_S = 0.02
BRAKE_S = SPEED / 10.0
HANG_S = 10.0
"""After which a port that has not come back hangs."""


def run(*, seed: int = 1, touches: int = 2, faults: int = 200, kills: int = 10) -> dict[str, float]:
    """Touches through the ports of MuJoCo, UR and ROS 2, times, faults and kills.

    `displacement_ratio` and `rise_ratio` are shares of what the gains say for the force and nearness felt.

    Args:
        seed: of touches and faults.
        touches: a mode and port.
        faults: injected into the UR port while it moves the robot.
        kills: of a process that moves the robot.
    """
    host = f"127.90.{os.getpid() // 250 % 250}.{1 + os.getpid() % 250}"
    random = np.random.default_rng(seed)
    figures: dict[str, float] = {}
    figures |= _touches_in_mujoco(random, touches)
    figures |= _touches_on_ur(host, random, touches, seed)
    figures |= _touches_on_ros2(random, touches, seed)
    with controller("ur5", host) as arm:
        figures |= _faults(host, arm, random, faults)
    figures |= _kills(host, random, kills)
    figures["load_average"] = os.getloadavg()[0]
    return figures


def _touches_in_mujoco(random: np.random.Generator, touches: int) -> dict[str, float]:
    from robotskin.layout import finished

    robot = load("ur5")
    worn = patch_of(finished("ur5"), "forearm_link")
    figures: dict[str, float] = {}
    for mode in MODES:
        tell(f"MuJoCo port, {mode}")
        answers = []
        for _ in range(touches):
            session = Session(robot, worn, seed=int(random.integers(1 << 30)), interface=mode, link="in process")
            session.boot()
            session.world.push(int(random.integers(len(worn))), float(random.uniform(6, 12)))
            answers.append(answer(session, worn, SETTLE_S, partial(_world_s, session)))
            session.shut_down()
        figures |= _worst(f"mujoco_{mode}", answers)
    return figures


def _touches_on_ur(host: str, random: np.random.Generator, touches: int, seed: int) -> dict[str, float]:
    figures: dict[str, float] = {}
    with stage(host, seed, controller("ur5", host)) as (units, robot, worn, keys):
        for mode in MODES:
            tell(f"UR port, {mode}")
            answers = []
            with connected(f"ur:{host}", units, robot, worn, keys, mode) as session:
                port = session.port
                assert isinstance(port, UrPort)
                before = (time.monotonic(), port.thread_seconds)
                for _ in range(touches):
                    answers += _touch(session, units, worn, random)
                gone = time.monotonic() - before[0]
                figures[f"ur_{mode}_cpu_percent"] = 100 * (port.thread_seconds - before[1]) / gone
                median, p99, _, _ = port.latency
                figures |= {f"ur_{mode}_command_median_ms": median * 1e3, f"ur_{mode}_command_p99_ms": p99 * 1e3}
                figures[f"ur_{mode}_limit_violations"] = float(session.controller.report.violations)
            figures |= _worst(f"ur_{mode}", answers)
            figures[f"ur_{mode}_touches"] = float(len(answers))
    return figures


def _touches_on_ros2(random: np.random.Generator, touches: int, seed: int) -> dict[str, float]:
    if importlib.util.find_spec("cyclonedds") is None or importlib.util.find_spec("rosbags") is None:
        tell("ROS 2 port: the extra ros2 is not installed")
        return {}
    from robotskin.rehearsal.ros2_process import forward_controllers

    domain = 100 + os.getpid() % 100
    figures: dict[str, float] = {}
    arm = forward_controllers("ur5", domain)
    with stage(f"ros2:{domain}", seed, arm) as (units, robot, worn, keys):
        for mode, controller_name in zip(MODES, ("position", "velocity", "effort"), strict=True):
            tell(f"ROS 2 port, {mode}")
            answers = []
            with connected(f"ros2:{domain},{controller_name}", units, robot, worn, keys, mode) as session:
                for _ in range(touches):
                    answers += _touch(session, units, worn, random)
                figures[f"ros2_{mode}_limit_violations"] = float(session.controller.report.violations)
            figures |= _worst(f"ros2_{mode}", answers)
            figures[f"ros2_{mode}_touches"] = float(len(answers))
    return figures


def _touch(session: ConnectedRobot, units: Process, worn: Layout, random: np.random.Generator) -> list[TouchAnswer]:
    """What a touch is answered with; none where other work on the machine stopped the robot meanwhile."""
    units.ask(Asked("push", (int(random.integers(len(worn))), float(random.uniform(6, 12)))))
    answered = answer(session, worn, SETTLE_S, time.monotonic)
    good = session.why_not_running() == "" and answered.asked_rad > 1e-3
    units.ask(Asked("release"))
    session.run(SETTLE_S)
    return [answered] if good else []


def _world_s(session: Session) -> float:
    return session.world.now_ns * 1e-9


def _worst(name: str, answers: list[TouchAnswer]) -> dict[str, float]:
    found: dict[str, float] = {}
    for figure in ("displacement", "rise") if answers else ():
        values = [getattr(one, figure) for one in answers]
        found |= {f"{name}_{figure}_ratio_least": min(values), f"{name}_{figure}_ratio_most": max(values)}
    return found


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
            time.sleep(0.002)

    def close(self) -> None:
        self.ending.set()
        self.thread.join()


def _faults(host: str, arm: Process, random: np.random.Generator, faults: int) -> dict[str, float]:
    port = UrPort(load("ur5").core, host, "UR5", within_s=20.0)
    mover = _Mover(port)
    hangs, beyond, longest_back_s, fastest = 0, 0, 0.0, 0.0
    try:
        for number in range(faults):
            if number % 20 == 0:
                tell(f"fault {number} of {faults}")
            time.sleep(random.uniform(0.02, 0.1))
            fault = str(random.choice(FAULTS))
            if fault == "stall":
                os.kill(arm.pid, signal.SIGSTOP)
                time.sleep(random.uniform(0.02, 0.3))
                os.kill(arm.pid, signal.SIGCONT)
            elif fault == "cut":
                arm.ask(Asked("cut"))
            else:
                arm.ask(Asked("trip", (fault,)))
                time.sleep(0.1)
                moving = float(np.abs(arm.ask(Look(("arm.velocity",)))[0]).max())
                beyond += moving > REST
                arm.ask(Asked("trip", ("normal",)))
            began, sent = time.monotonic(), mover.sent
            while (port.condition is not UrCondition.ready or mover.sent == sent) and time.monotonic() < began + HANG_S:
                time.sleep(0.005)
            hangs += time.monotonic() - began >= HANG_S
            longest_back_s = max(longest_back_s, time.monotonic() - began)
            fastest = max(fastest, float(np.abs(arm.ask(Look(("arm.velocity",)))[0]).max()))
        return {
            "ur_faults": float(faults),
            "ur_hangs": float(hangs),
            "ur_moving_after_stop": float(beyond),
            "ur_longest_back_s": longest_back_s,
            "ur_fastest_rad_s": fastest,
            "ur_speed_commanded_rad_s": SPEED,
            "ur_connections": float(port.connections),
        }
    finally:
        mover.close()
        port.close()


class Commander:
    """Moves the robot at an address, in a process of its own."""

    def __init__(self, host: str) -> None:
        self._port = UrPort(load("ur5").core, host, "UR5", within_s=20.0)
        self._state, self._command = JointState(6), JointCommand(CommandMode.velocity, 6)
        self._command.value = np.array([SPEED, 0, 0, 0, 0, 0])

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


def _kills(host: str, random: np.random.Generator, kills: int) -> dict[str, float]:
    rest_s = []
    with controller("ur5", host) as arm:
        for number in range(kills):
            tell(f"kill {number} of {kills}")
            commander = Process(Commander, host=host)
            time.sleep(0.2 + random.uniform(0.0, 0.1))
            commander.kill()
            killed = arm.ask(Look(("steps",)))[0]
            while np.abs(arm.ask(Look(("arm.velocity",)))[0]).max() > REST:
                time.sleep(0.001)
            rest_s.append((arm.ask(Look(("steps",)))[0] - killed) * 0.002)
    allowed = LIFE_S + BRAKE_S
    return {
        "kills": float(kills),
        "kill_rest_worst_s": max(rest_s, default=0.0),
        "kill_rest_beyond_stop_s": max(0.0, max(rest_s, default=0.0) - allowed),
    }
