# SPDX-License-Identifier: Apache-2.0
"""A switch that records a running session: files are opened and ended beside the thread that moves the robot."""

from __future__ import annotations

import threading
import time
from collections.abc import Callable
from pathlib import Path

from robotskin.record import Recorder, RecordError
from robotskin.record.facts import Recorded
from robotskin.record.recorder import is_recorded

__all__ = ["RecordSwitch"]


class RecordSwitch:
    """Starts and ends recordings of `session`, one after the other, in the folder of the process.

    `ask` hands a request to the thread that moves the robot. Every method may be called from any thread but that one.
    """

    def __init__(self, session: Recorded, ask: Callable[[Callable[[], object]], None]) -> None:
        self._session, self._ask = session, ask
        self._lock = threading.Lock()
        self._recorder: Recorder | None = None
        self.told = ""
        """What is recorded, or was last, and where."""

    @property
    def on(self) -> bool:
        """Whether it records."""
        return self._recorder is not None

    def set(self, on: bool) -> None:
        """Record into a new file, or end it. Raises RecordError where the skin is recorded or shown already."""
        with self._lock:
            if on and self._recorder is None:
                self._start()
            elif not on and self._recorder is not None:
                self._end(self._recorder)

    def close(self) -> None:
        """End the recording, after the thread that moved the robot has ended."""
        with self._lock:
            recorder, self._recorder = self._recorder, None
        if recorder is not None:
            recorder.close()

    def _start(self) -> None:
        if is_recorded(self._session):
            raise RecordError("this skin is recorded or shown already, since its start")
        path = Path(time.strftime(f"{self._session.layout.robot}_%Y-%m-%d_%H-%M-%S.mcap"))
        recorder = Recorder(path, self._session, attached=False, tell=self._say)
        try:
            self._ask(recorder.attach)
        except BaseException:
            recorder.close()
            raise
        self._recorder = recorder
        self.told = f"recording into {path.resolve()}"

    def _say(self, text: str) -> None:
        self.told = text

    def _end(self, recorder: Recorder) -> None:
        detached = threading.Event()

        def detach() -> None:
            recorder.detach()
            detached.set()

        self._ask(detach)
        if not detached.wait(5.0):
            raise RecordError("the session does not answer; the recording ends with it")
        self._recorder = None
        recorder.close()  # raises where the file is not whole, and then what was told stays
        self.told = f"recorded into {recorder.path}"
