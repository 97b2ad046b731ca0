# SPDX-License-Identifier: Apache-2.0
"""How Ctrl-C and SIGTERM reach a verb: as KeyboardInterrupt, and never in the middle of an import."""

from __future__ import annotations

import signal
import threading
from types import FrameType
from typing import Any

IMPORT_AGAIN_S = 0.05
"""While an import runs, a signal waits so long before it looks again."""


def importing(frame: FrameType | None) -> bool:
    """Whether what runs in `frame` was called by an import."""
    while frame is not None:
        if frame.f_code.co_filename.startswith("<frozen importlib"):
            return True
        frame = frame.f_back
    return False


class Interruption:
    """While it is entered, SIGTERM ends a verb as Ctrl-C does, also where a script has set SIGINT to be ignored.

    Libraries take whatever is raised while they import others for a sign that those are missing, and go on. So an
    interrupt waits for the end of an import, and is raised then.
    """

    def __init__(self) -> None:
        self.came: int | None = None
        self._before: dict[signal.Signals, Any] = {}

    def __enter__(self) -> Interruption:
        if threading.current_thread() is threading.main_thread():
            self._before[signal.SIGALRM] = signal.signal(signal.SIGALRM, self._raise)
            for one in (signal.SIGINT, signal.SIGTERM):
                if one is signal.SIGTERM or signal.getsignal(one) is not signal.SIG_IGN:
                    self._before[one] = signal.signal(one, self._end)
        return self

    def __exit__(self, *_: object) -> None:
        if self._before:
            signal.setitimer(signal.ITIMER_REAL, 0.0)
        for one, handler in self._before.items():
            signal.signal(one, handler)

    def _end(self, number: int, frame: FrameType | None) -> None:
        self.came = number
        self._raise(number, frame)

    def _raise(self, _number: int, frame: FrameType | None) -> None:
        if importing(frame):
            signal.setitimer(signal.ITIMER_REAL, IMPORT_AGAIN_S)
        else:
            signal.setitimer(signal.ITIMER_REAL, 0.0)
            raise KeyboardInterrupt
