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
from robotskin.record.recording import Frame, Recording
from robotskin.robots.gains import GainSet, gains_of
from robotskin.robots.gains.gain_file import read_gains

TICKS_PER_REPORT = 500
MODES = list(CommandMode)
UNITS = ("rad or m", "rad/s or m/s", "Nm or N")
"""Of commands, by the number of their interface."""


@dataclass(frozen=True)
class OpenLoop:
    """Commands of T ticks. `speed` is in multiples of real time, of all that was stepped."""

    joint_names: tuple[str, ...]
    mode: CommandMode
    seconds: float
    speed: float
    commanded: NDArray[np.float64]
    """(T, n) by this controller; rad, rad/s or Nm, for prismatic joints m, m/s or N."""
    recorded: NDArray[np.float64]
    """(T, n) what was sent to the robot in the same tick."""
    ended_by_clock: NDArray[np.bool_]
    """(T) whether a clock ended the fusion of what was sent in that tick: such ticks are not compared."""
    begun_s: float = 0.0
    """When goal and fusion began, since the recording's beginning: with the first zero of the forces."""

    @property
    def compared(self) -> NDArray[np.bool_]:
        """(T) ticks that are."""
        return ~self.ended_by_clock

    @property
    def difference(self) -> NDArray[np.float64]:
        """(n) root mean square of the difference of each joint, over the ticks compared; NaN: none is."""
        if not self.compared.any():
            return np.full(len(self.joint_names), np.nan)
        return np.sqrt(((self.commanded - self.recorded)[self.compared] ** 2).mean(axis=0))

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


class BehaviourSteps:
    """A behaviour's tasks, their fusion and the guard, stepped with the frames of a recording. It moves nothing.

    When the forces' zero is taken, goal and fusion begin anew: what each sensor felt before was its own offset.

    gains: by default those of the recording, else the robot's own.

    Raises RecordingFileError: no robot is in it. Raises GainError: damaged gains. Raises UnknownNameError: no such
    behaviour.
    """

    def __init__(self, recording: Recording, behaviour: str | Behaviour, gains: GainSet | None = None) -> None:
        self.robot = recorded_robot(recording)
        self._recording, self._behaviour = recording, behaviour
        self._gains = gains or recorded_gains(recording) or gains_of(self.robot)
        self.mode: int | None = None
        """Number of the recorded interface, by which it commands, too; None: no frame was stepped yet."""
        self.begun_ns = 0
        """Time of the frame at which goal and fusion began; 0: no frame was stepped yet."""
        self._zeroed = False
        self.begin()

    @property
    def name(self) -> str:
        """Of the behaviour."""
        return self._behaviour if isinstance(self._behaviour, str) else self._behaviour.name

    def begin(self) -> None:
        """Goal and fusion begin anew, at the next frame."""
        self._zeroed = False
        self._begin()

    def _begin(self) -> None:
        self.begun_ns = 0
        layout = self._recording.layout
        self._controller = Controller(self.robot.core, layout.skin_model(), self._gains, self._behaviour)
        self._controller.cycle.request_run(True)
        self._joints = JointState(self.robot.joint_count)
        self._command = JointCommand(CommandMode.position, self.robot.joint_count)
        self.mode = None

    def fits(self, frame: Frame) -> bool:
        """Whether joints and a command of this robot are in it."""
        return len(frame.position) == self.robot.joint_count == len(frame.command)

    def step(self, frame: Frame) -> NDArray[np.float64]:
        """(n) what it commands in the tick of a frame that fits, in the unit of the recorded interface."""
        if not self._zeroed and frame.zeroed:
            self._zeroed = True
            if self.begun_ns:
                self._begin()
        self.begun_ns = self.begun_ns or frame.time_ns
        if frame.command_mode != self.mode:
            self.mode = frame.command_mode
            if self.mode < len(MODES):  # joints with interfaces of their own go on by the last one
                self._command.mode = MODES[self.mode]
                self._controller.cycle.request_mode(MODES[self.mode])
        joints = self._joints
        joints.position, joints.velocity, joints.stamp_ns = frame.position, frame.velocity, frame.time_ns
        self._controller.cycle.step(joints, frame.skin, frame.time_ns, self._command)
        return np.array(self._command.value)


def open_loop(
    recording: Recording,
    behaviour: str | Behaviour,
    start_s: float = 0.0,
    end_s: float = float("inf"),
    *,
    gains: GainSet | None = None,
    progress: Callable[[float], None] = lambda done: None,
) -> OpenLoop:
    """Step a behaviour with recorded joints and skin from the beginning on; compare between two times.

    So goal and fusion at `start_s` are as in a comparison of the whole. The joints are where they were, whatever it
    commands. gains: see `BehaviourSteps`. progress: hears how many seconds are done.

    Raises RecordingFileError: damaged, or no joints and commands of one interface are in that time. Raises GainError:
    damaged gains. Raises UnknownNameError: no such behaviour.
    """
    steps = BehaviourSteps(recording, behaviour, gains)
    begin_ns = recording.start_ns + int(start_s * 1e9)
    commanded: list[NDArray] = []
    recorded: list[NDArray] = []
    by_clock: list[bool] = []
    mode: int | None = None
    first_ns = begun_ns = last_ns = 0
    counted = 0
    began = time.monotonic()
    for frame in recording.frames(0.0, end_s):
        if not steps.fits(frame):
            continue
        # What was sent in a tick is known at the next one.
        if commanded:
            recorded.append(np.array(frame.command))
            by_clock.append(frame.command_by_clock)
        command = steps.step(frame)
        begun_ns, last_ns = begun_ns or frame.time_ns, frame.time_ns
        if frame.time_ns >= begin_ns:
            if mode is None:
                mode, first_ns = frame.command_mode, frame.time_ns
                if mode >= len(MODES):
                    raise RecordingFileError(f"{recording.path}: its joints have interfaces of their own: not compared")
            elif frame.command_mode != mode:
                raise RecordingFileError(f"{recording.path}: its interface changes at {frame.time_ns / 1e9:.3f} s")
            commanded.append(command)
        counted += 1
        if counted % TICKS_PER_REPORT == 0:
            progress((last_ns - begun_ns) / 1e9)
    if mode is None or not recorded:
        raise RecordingFileError(f"{recording.path}: no joints and commands are in it")
    speed = (last_ns - begun_ns) / 1e9 / max(time.monotonic() - began, 1e-9)
    return OpenLoop(
        tuple(steps.robot.joint_names), MODES[mode], (last_ns - first_ns) / 1e9, speed,
        np.array(commanded[: len(recorded)]), np.array(recorded), np.array(by_clock),
        (steps.begun_ns - recording.start_ns) / 1e9,
    )  # fmt: skip
