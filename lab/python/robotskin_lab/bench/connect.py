# SPDX-License-Identifier: Apache-2.0
"""`robotskin bench connect`: the ports of UR, Franka and ROS 2 and the whole loop, against rehearsed controllers."""

from __future__ import annotations

import importlib.util
import os
import time
from collections.abc import Callable
from functools import partial
from typing import Annotated, Any

import numpy as np
import typer

from robotskin import choices
from robotskin.connecting import ConnectedRobot
from robotskin.errors import UnknownNameError
from robotskin.layout import Layout
from robotskin.rehearsal import Asked, Look, Process, controller, franka_controller
from robotskin.rehearsal.franka_process import STEP_S as FRANKA_STEP_S
from robotskin.robots import load
from robotskin.session import Session
from robotskin.ur import UrPort
from robotskin_lab.bench.connect_faults import faults_of, side_by_side
from robotskin_lab.bench.connect_forged import forged_of
from robotskin_lab.bench.connect_kills import kills_of
from robotskin_lab.bench.connect_rig import connected, patch_of, stage
from robotskin_lab.bench.progress import tell
from robotskin_lab.bench.touch_answer import TouchAnswer, answer

MODES = choices.INTERFACES
SETTLE_S = 3.0
PARTS = "mujoco,ur,franka,ros2,faults,kills,forged"
FRANKA_LINK = "panda_link4"


def run(
    *,
    seed: int = 1,
    touches: int = 2,
    faults: int = 200,
    kills: int = 10,
    forged: Annotated[int, typer.Option(help="Frames at fresh cells.", min=1)] = 100_000,
    datagrams: Annotated[int, typer.Option(help="Forged ones into the sockets of a running skin.", min=3)] = 3000,
    side: Annotated[int, typer.Option(help="Controllers side by side for faults and kills.", min=1)] = 4,
    parts: Annotated[str, typer.Option(help=f"Some of {PARTS}.")] = PARTS,
) -> dict[str, Any]:
    """Touches through the ports of MuJoCo, UR, Franka and ROS 2, times, faults and kills.

    `displacement_ratio` and `rise_ratio` are shares of what the gains say for the force and nearness felt.

    Args:
        seed: of touches and faults.
        touches: a mode and port.
        faults: injected into the UR port while it moves the robot.
        kills: of processes that move the robot, or hold its skin or page.
        forged: frames, replayed and guessed ones among them, at fresh cells in virtual time.
        datagrams: forged and replayed ones into the sockets of a running skin.
        side: how many robots share faults and kills.
        parts: what to measure.
    """
    first = os.getpid() % 200 + 1
    hosts = [f"127.90.{os.getpid() // 200 % 200}.{first + index}" for index in range(min(side, 50))]
    makers: dict[str, Callable[[], dict[str, float]]] = {
        "mujoco": lambda: _touches_in_mujoco(np.random.default_rng(seed), touches),
        "ur": lambda: _touches_on_ur(hosts[0], np.random.default_rng([seed, 1]), touches, seed),
        "franka": lambda: _touches_on_franka(hosts[0], np.random.default_rng([seed, 3]), touches, seed),
        "ros2": lambda: _touches_on_ros2(np.random.default_rng([seed, 2]), touches, seed),
        "faults": lambda: side_by_side(faults_of, hosts, seed, faults),
        "kills": lambda: kills_of(hosts, seed, kills),
        "forged": lambda: forged_of(hosts[0], seed, forged, datagrams),
    }
    figures: dict[str, float] = {}
    for part in parts.split(","):
        if part not in makers:
            raise UnknownNameError("part", part, list(makers))
        figures |= makers[part]()
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


def _touches_on_franka(host: str, random: np.random.Generator, touches: int, seed: int) -> dict[str, float]:
    missing = [name for name in ("pylibfranka", "franky_sim") if importlib.util.find_spec(name) is None]
    if missing:
        tell(f"Franka port: {' and '.join(missing)} not installed")
        return {}
    figures: dict[str, float] = {}
    arm = franka_controller("panda", host)
    with stage(f"franka:{host}", seed, arm, "panda", FRANKA_LINK) as (units, robot, worn, keys):
        for mode in MODES:
            tell(f"Franka port, {mode}")
            answers = []
            with connected(f"franka:{host}", units, robot, worn, keys, mode) as session:
                began, steps = time.monotonic(), arm.ask(Look(("steps",)))[0]
                for _ in range(touches):
                    answers += _touch(session, units, worn, random)
                figures[f"franka_{mode}_limit_violations"] = float(session.controller.report.violations)
                # Below 1 the machine is too busy for the rehearsed robot, and rises look slow.
                gone_s = (arm.ask(Look(("steps",)))[0] - steps) * FRANKA_STEP_S
                figures[f"franka_{mode}_time_ratio"] = gone_s / (time.monotonic() - began)
            figures |= _worst(f"franka_{mode}", answers)
            figures[f"franka_{mode}_touches"] = float(len(answers))
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
