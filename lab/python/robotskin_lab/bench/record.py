# SPDX-License-Identifier: Apache-2.0
"""Recordings: what they cost beside the robot, how they come back, what a kill takes, how many bytes events save."""

from __future__ import annotations

import gc
import tempfile
import time
from collections.abc import Sequence
from pathlib import Path
from typing import Annotated, Any

import numpy as np
import typer

from robotskin import choices, layout, robots
from robotskin.model import CommandMode, JointCommand, JointState
from robotskin.record import Recorder, Recording, recorded
from robotskin.session import PERIOD_S, Session
from robotskin_lab.bench.progress import tell
from robotskin_lab.bench.record_kills import ROBOT as KILLED
from robotskin_lab.bench.record_kills import cut_files, killed_writers
from robotskin_lab.bench.record_load import digest, loaded

STRETCH_TICKS = 2000
"""Ticks in a row with a recorder, or without one."""
WARM_TICKS = 200
"""Before each stretch, not measured: a writer that has just started leaves cold caches, and the first keyframe."""
ROUNDS = 60
"""Each is three stretches in a drawn order: one with a recorder, two without."""
TOUCH_S, EVERY_S = 2.0, 10.0
WHOLE_S = 2.0
"""Of the recording that is cut."""


def run(
    *,
    seed: int = 1,
    seconds: Annotated[float, typer.Option(help="Of the load of the largest skin.")] = 10.0,
    kills: Annotated[int, typer.Option(help="Writers that are killed at random instants.")] = 100,
    cuts: Annotated[int, typer.Option(help="Files that are cut at random bytes.")] = 900,
    touch_seconds: Annotated[float, typer.Option(help="Of a UR5 in clock mode and in event mode.")] = 20.0,
    short: Annotated[bool, typer.Option("--short", help="A tenth of everything.")] = False,
) -> dict[str, Any]:
    """Record the largest skin's load and replay it, kill writers, cut files, and weigh events against the clock."""
    if short:
        seconds, kills, cuts, touch_seconds = 1.0, 5, 20, 4.0
    figures: dict[str, Any] = {}
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        tell("record: the load of the largest skin")
        figures |= _load(folder / "load.mcap", seconds, seed)
        tell("record: the control thread with and without")
        figures |= _ticks(folder, 1 if short else ROUNDS, seed)
        tell("record: kills and cuts")
        lost = killed_writers(folder, kills, seed)
        # Of a small skin: a large one would be copied and mended for hours.
        loaded(folder / "whole.mcap", WHOLE_S, seed, KILLED)
        lost.add(cut_files(folder, folder / "whole.mcap", cuts, seed))
        figures |= lost.figures()
        tell("record: events against the clock")
        figures |= _events(folder, touch_seconds, seed)
    tell("")
    return figures


def _load(path: Path, seconds: float, seed: int) -> dict[str, Any]:
    """1260 cells at 250 Hz, no faster than the wall clock; then back, to the byte."""
    done = loaded(path, seconds, seed)
    recording = Recording(path)
    same, read, started = True, 0, time.process_time()
    for frame in recording.frames():
        read += 1
        same = same and done.digests.get(frame.time_ns) == digest(frame.skin)
    compared_s = time.process_time() - started
    started = time.process_time()
    for _ in recording.frames():
        pass
    replay_s = time.process_time() - started
    return {
        "frames_a_second": done.frames / seconds,
        "record_cpu_percent": 100 * done.recorder_cpu_s / seconds,
        "record_dropped": done.dropped,
        "record_mb_per_s": path.stat().st_size / 1e6 / seconds,
        "replay_identical": float(same and read > 0.95 * seconds / PERIOD_S),
        "replay_reads": read,
        "replay_speed": seconds / replay_s,
        "replay_speed_compared": seconds / compared_s,
    }


def _ticks(folder: Path, rounds: int, seed: int) -> dict[str, Any]:
    """Processor time of the control thread's tick with a recorder and without; and a replay with tasks.

    What else runs on the machine moves the p99 of a stretch by a fifth and more, and that of the stretches beside it
    alike. So each round compares its own, and the median of the rounds counts. The ratio of the two stretches without a
    recorder tells how far this can be trusted.
    """
    session, draw = _session(seed, "clock"), np.random.default_rng([seed, 5])
    p99_us: dict[str, list[float]] = {"with": [], "without": [], "without too": []}
    gc.disable()
    try:
        for number in range(rounds):
            for which in draw.permutation(list(p99_us)):
                path = folder / f"ticks{number}.mcap" if which == "with" else None
                with recorded(session, path):
                    p99_us[str(which)].append(_p99_us(session))
    finally:
        gc.enable()
    with_, without, too = (np.array(p99_us[which]) for which in ("with", "without", "without too"))
    return {
        "tick_p99_us": float(np.median(with_)),
        "peer_tick_p99_us": float(np.median(np.concatenate([without, too]))),
        "tick_p99_ratio": float(np.median(with_ / np.sqrt(without * too))),
        "peer_tick_p99_ratio": float(np.median(too / without)),
        "tick_rounds": rounds,
        "replay_speed_with_tasks": _speed_with_tasks(sorted(folder.glob("ticks*.mcap")), session),
    }


def _p99_us(session: Session) -> float:
    """Of the processor time of a stretch of ticks."""
    times = np.empty(WARM_TICKS + STRETCH_TICKS)
    for tick in range(len(times)):
        session.world.step(PERIOD_S)
        session.world.exchange(session.driver)
        before = time.thread_time_ns()
        session.loop.step(session.world.now_ns)
        times[tick] = time.thread_time_ns() - before
    return float(np.quantile(times[WARM_TICKS:], 0.99)) / 1e3


def _speed_with_tasks(paths: Sequence[Path], session: Session) -> float:
    """Times real time, with the recorded joints and skin through the controller's tasks, fusion and guard."""
    count = session.robot.joint_count
    joints, command = JointState(count), JointCommand(CommandMode.position, count)
    controller, reads = session.controller, 0
    controller.cycle.request_run(True)
    started = time.process_time()
    for path in paths:
        for frame in Recording(path).frames():
            if len(frame.position) != count:
                continue
            joints.position, joints.velocity, joints.stamp_ns = frame.position, frame.velocity, frame.time_ns
            controller.cycle.step(joints, frame.skin, frame.time_ns, command)
            reads += 1
    return reads * PERIOD_S / (time.process_time() - started)


def _events(folder: Path, seconds: float, seed: int) -> dict[str, Any]:
    """Bytes of skin messages of a UR5 that is touched for 2 s every 10 s."""
    figures: dict[str, Any] = {}
    for mode in choices.MODES:
        session = _session(seed, mode)
        cell = int(np.random.default_rng([seed, 3]).integers(len(session.layout)))
        path = folder / f"{mode}.mcap"
        with Recorder(path, session):
            for tick in range(round(seconds / PERIOD_S)):
                at_s = tick * PERIOD_S % EVERY_S
                if abs(at_s - 1.0) < PERIOD_S / 2:
                    session.world.push(cell, 8.0)
                elif abs(at_s - 1.0 - TOUCH_S) < PERIOD_S / 2:
                    session.world.release()
                session.step()
        recording = Recording(path)
        figures[f"bytes_a_second_{mode}"] = recording.bytes_of("/skin/tape", "/skin/samples") / seconds
        figures[f"messages_a_second_{mode}"] = len(recording.samples()["key"]) / seconds
    figures["event_bytes_ratio"] = figures["bytes_a_second_event"] / figures["bytes_a_second_clock"]
    return figures


def _session(seed: int, mode: str) -> Session:
    session = Session(robots.load("ur5"), layout.finished("ur5"), seed=seed, mode=mode, link="in process")
    session.boot()
    return session
