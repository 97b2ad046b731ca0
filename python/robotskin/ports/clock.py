# SPDX-License-Identifier: Apache-2.0
"""The time in which a port lives: the host's, or that of a simulated world."""

from __future__ import annotations

import time
from typing import Protocol


class Clock(Protocol):
    """Tells the time of stamps, and lets time pass."""

    def now_ns(self) -> int:
        """The clock of all stamps."""

    def wait(self, seconds: float) -> None:
        """Let so much time pass."""


class HostClock:
    """The host's monotonic clock."""

    def now_ns(self) -> int:
        """Nanoseconds."""
        return time.monotonic_ns()

    def wait(self, seconds: float) -> None:
        """Sleep."""
        time.sleep(seconds)
