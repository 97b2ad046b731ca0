# SPDX-License-Identifier: Apache-2.0
"""A recording that plays by itself, for a page: played, paused, stepped, sought, at any speed."""

from __future__ import annotations

import time
from collections import deque
from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from robotskin.errors import InputError
from robotskin.live.own_thread import OwnThread
from robotskin.record import Frame, Recording, RecordingFileError
from robotskin.record.open_loop import UNITS, BehaviourSteps
from robotskin.record.recorded_robot import recorded_robot
from robotskin.viewer.session_view import Floats, SkinReading

__all__ = ["Compared", "Moment", "Replay"]

SPEED_MAX = 10.0
LOOKS_BACK_S = (0.1, 2.0)
"""Where the last read is looked for before the whole recording is."""
AWAKE_S = 0.02
BUSY_S = 0.05
"""Played at once at most; a machine that cannot keep the speed plays slower, and stays obedient."""


@dataclass(frozen=True)
class Compared:
    """What a behaviour would have commanded, beside what was sent in the same tick; n joints, in `unit`.

    since_s: its goal and its fusion began at that time of the recording.
    """

    behaviour: str
    since_s: float
    unit: str
    commanded: Floats
    sent: Floats


@dataclass(frozen=True)
class Moment:
    """What a page shows of a replay. time_s: since the beginning; joint_position: (n,) rad or m.

    compared: None where no behaviour is stepped, or none of its ticks was yet.
    """

    time_s: float
    joint_position: Floats
    skin: SkinReading
    playing: bool
    speed: float
    compared: Compared | None = None


class Replay(OwnThread):
    """Plays a recording of N cells through the shipping driver and reader until `close`; it begins paused.

    Every method may be called from any thread and returns at once.

    Args:
        behaviour: its tasks are stepped, too, with the recorded joints and skin. Where it is sought, goal and fusion
            begin anew.

    Raises:
        RecordingFileError: no robot is in it, or no moment. UnknownNameError: no such behaviour.
    """

    def __init__(self, recording: Recording, behaviour: str | None = None) -> None:
        super().__init__("replay", RecordingFileError, daemon=True)
        self._steps = None if behaviour is None else BehaviourSteps(recording, behaviour)
        self.compares = behaviour is not None
        self._commanded: Floats | None = None
        """In the tick of the last frame."""
        self._since_s = 0.0
        self._compared: Compared | None = None
        self.recording = recording
        self.robot = recorded_robot(recording)
        self.layout = recording.layout
        self.seconds = recording.seconds
        self._position = self.robot.neutral
        self._playing, self._speed = False, 1.0
        self._at_s = 0.0
        self._began = (0.0, 0.0)
        """Wall clock and time of the recording since which it plays."""
        self._frames: Iterator[Frame] = iter(())
        self._skin: SkinReading | None = None
        self._go_to(0.0)
        if self._skin is None:
            raise RecordingFileError(f"{recording.path}: no moment of a skin is in it")
        self._moment: Moment = self._take(self._skin)
        self._begin()

    # ---- Any thread ----

    def moment(self) -> Moment:
        """The latest."""
        return self._moment

    def play(self) -> None:
        """Go on, at the end from the beginning."""
        self._ask(self._play)

    def pause(self) -> None:
        """Stand still."""
        self._ask(self._pause)

    def step(self) -> None:
        """One read of the skin further, and stand still."""
        self._ask(self._step)

    def seek(self, time_s: float) -> None:
        """Go to a time since the beginning. Raises InputError for one outside."""
        if not 0.0 <= time_s <= self.seconds:
            raise InputError(f"time {time_s:.2f} s: the recording has 0 to {self.seconds:.2f} s")
        self._ask(lambda: self._go_to(time_s))

    def set_speed(self, speed: float) -> None:
        """Seconds of the recording for one of the wall clock. Raises InputError."""
        if not 0.0 < speed <= SPEED_MAX:
            raise InputError(f"speed {speed}: more than 0, at most {SPEED_MAX:.0f}")
        self._ask(lambda: self._set_speed(speed))

    # ---- On its thread ----

    def _work(self) -> None:
        while not self._closing.is_set():
            asked = False
            while self._obey():
                asked = True
            if self._playing:
                self._catch_up()
            elif not asked:
                self._closing.wait(AWAKE_S)
            if self._skin is not None:
                self._moment = self._take(self._skin)

    def _catch_up(self) -> None:
        due_s = self._began[1] + (time.monotonic() - self._began[0]) * self._speed
        ends = time.monotonic() + BUSY_S
        last: Frame | None = None
        while self._at_s < due_s:
            frame = next(self._frames, None)
            if frame is None:
                self._playing = False
                break
            last = frame
            self._compare(frame)
            self._at_s = (frame.time_ns - self.recording.start_ns) * 1e-9
            if time.monotonic() > ends:
                self._restart_clock()
                break
        if last is not None:
            self._keep(last)
        if self._playing:
            self._closing.wait(AWAKE_S)

    def _play(self) -> None:
        if self._at_s >= self.seconds - 0.01:
            self._go_to(0.0)
        self._playing = True
        self._restart_clock()

    def _pause(self) -> None:
        self._playing = False

    def _step(self) -> None:
        self._playing = False
        frame = next(self._frames, None)
        if frame is not None:
            self._compare(frame)
            self._keep(frame)

    def _set_speed(self, speed: float) -> None:
        self._speed = speed
        self._restart_clock()

    def _go_to(self, time_s: float) -> None:
        self._frames = self.recording.frames(time_s)
        frame = next(self._frames, None)
        if frame is None:
            frame = self._last_read(time_s)
        if frame is not None:
            self._keep(frame)
            self._compare_anew(frame)
        self._restart_clock()

    def _compare_anew(self, frame: Frame) -> None:
        """Goal and fusion begin at a frame."""
        if self._steps is None:
            return
        self._steps.begin()
        self._commanded = self._compared = None
        self._since_s = self._at_s
        self._compare(frame)

    def _compare(self, frame: Frame) -> None:
        """Step the behaviour; what was sent in a tick is known at the next one.

        A tick that a clock ended is passed over: nothing repeats it.
        """
        if self._steps is None or not self._steps.fits(frame):
            return
        mode = self._steps.mode
        commanded = None if frame.command_by_clock else self._commanded
        if commanded is not None and mode is not None and mode == frame.command_mode:
            unit = UNITS[mode] if mode < len(UNITS) else "each joint in its own unit"
            self._compared = Compared(self._steps.name, self._since_s, unit, commanded, np.array(frame.command))
        before_ns = self._steps.begun_ns
        self._commanded = self._steps.step(frame)
        if before_ns and self._steps.begun_ns != before_ns:
            self._since_s = (self._steps.begun_ns - self.recording.start_ns) / 1e9

    def _last_read(self, time_s: float) -> Frame | None:
        """The skin's last read before a time after which there is none: a recording may end with something else."""
        for back_s in (*LOOKS_BACK_S, time_s):
            last = deque(self.recording.frames(max(0.0, time_s - back_s), time_s), maxlen=1)
            if last:
                return last[0]
        return None

    def _restart_clock(self) -> None:
        self._began = (time.monotonic(), self._at_s)

    def _keep(self, frame: Frame) -> None:
        self._at_s = (frame.time_ns - self.recording.start_ns) * 1e-9
        if len(frame.position) == self.robot.joint_count and np.isfinite(frame.position).all():
            self._position = np.array(frame.position)
        self._skin = SkinReading.of(frame.skin, frame.time_ns)

    def _take(self, skin: SkinReading) -> Moment:
        return Moment(self._at_s, self._position, skin, self._playing, self._speed, self._compared)
