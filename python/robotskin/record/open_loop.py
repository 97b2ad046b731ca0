# SPDX-License-Identifier: Apache-2.0
"""A controller on a recording: what it would have commanded, beside what was commanded. It moves nothing."""

from __future__ import annotations

import time
from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from robotskin.control import Behaviour
from robotskin.control.controller import Controller
from robotskin.model import CommandMode, JointCommand, JointState
from robotskin.record.facts import GAINS
from robotskin.record.mcap_file import RecordingFileError
from robotskin.record.recorded_robot import recorded_robot
from robotskin.record.recording import Recording
from robotskin.robots.gains import GainSet, gains_of
from robotskin.robots.gains.gain_file import read_gains

TICKS_PER_REPORT = 500


@dataclass(frozen=True)
class OpenLoop:
    """Commands of T ticks. `speed` is in multiples of real time."""

    joint_names: tuple[str, ...]
    mode: CommandMode
    seconds: float
    speed: float
    commanded: NDArray[np.float64]
    """(T, n) by this controller; rad, rad/s or Nm, for prismatic joints m, m/s or N."""
    recorded: NDArray[np.float64]
    """(T, n) what was sent to the robot in the same tick."""

    @property
    def difference(self) -> NDArray[np.float64]:
        """(n) root mean square of the difference of each joint."""
        return np.sqrt(((self.commanded - self.recorded) ** 2).mean(axis=0))

    @property
    def moved(self) -> NDArray[np.float64]:
        """(n) standard deviation of what was recorded, which a difference is to be judged by."""
        return np.asarray(self.recorded.std(axis=0))


def recorded_gains(recording: Recording) -> GainSet | None:
    """With which it was recorded; None in a file that does not say. Raises GainError for damaged ones."""
    text = recording.attachments.get(GAINS)
    if text is None:
        return None
    return GainSet(recording.layout.robot, read_gains(text.decode(errors="replace"), f"{recording.path}: {GAINS}"))


def open_loop(
    recording: Recording,
    behaviour: str | Behaviour,
    start_s: float = 0.0,
    end_s: float = float("inf"),
    *,
    gains: GainSet | None = None,
    progress: Callable[[float], None] = lambda done: None,
) -> OpenLoop:
    """Step a behaviour's tasks, their fusion and the guard with recorded joints and skin, between two times.

    The joints are where they were, whatever it commands. gains: by default those of the recording, else the robot's
    own. progress: hears how many seconds are done.

    Raises RecordingFileError: damaged, or no joints and commands of one interface are in it. Raises GainError: damaged
    gains. Raises UnknownNameError: no such behaviour.
    """
    robot = recorded_robot(recording)
    controller = Controller(
        robot.core, recording.layout.skin_model(), gains or recorded_gains(recording) or gains_of(robot), behaviour
    )
    controller.cycle.request_run(True)
    count, modes = robot.joint_count, list(CommandMode)
    joints, command = JointState(count), JointCommand(CommandMode.position, count)
    commanded: list[NDArray] = []
    recorded: list[NDArray] = []
    mode: int | None = None
    first_ns = last_ns = 0
    began = time.monotonic()
    for frame in recording.frames(start_s, end_s):
        if len(frame.position) != count or len(frame.command) != count:
            continue
        # What was sent in a tick is known at the next one.
        if commanded:
            recorded.append(np.array(frame.command))
        if mode is None:
            mode, first_ns = frame.command_mode, frame.time_ns
            if mode >= len(modes):
                raise RecordingFileError(f"{recording.path}: its joints have interfaces of their own: not compared")
            command.mode = modes[mode]
            controller.cycle.request_mode(modes[mode])
        elif frame.command_mode != mode:
            raise RecordingFileError(f"{recording.path}: its interface changes at {frame.time_ns / 1e9:.3f} s")
        joints.position, joints.velocity, joints.stamp_ns = frame.position, frame.velocity, frame.time_ns
        controller.cycle.step(joints, frame.skin, frame.time_ns, command)
        commanded.append(np.array(command.value))
        last_ns = frame.time_ns
        if len(commanded) % TICKS_PER_REPORT == 0:
            progress((last_ns - first_ns) / 1e9)
    if mode is None or not recorded:
        raise RecordingFileError(f"{recording.path}: no joints and commands are in it")
    seconds = (last_ns - first_ns) / 1e9
    return OpenLoop(
        tuple(robot.joint_names), modes[mode], seconds, seconds / max(time.monotonic() - began, 1e-9),
        np.array(commanded[: len(recorded)]), np.array(recorded),
    )  # fmt: skip
