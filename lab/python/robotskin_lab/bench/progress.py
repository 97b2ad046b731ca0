# SPDX-License-Identifier: Apache-2.0
"""Progress of a measurement that takes minutes: one line of the terminal, or a line a step where there is none."""

from __future__ import annotations

import sys
import time

STEPS_PAUSE_S = 20.0
_told_step_s = -STEPS_PAUSE_S


def tell(text: str) -> None:
    """Say what is being measured, on the error stream; "" takes the line away."""
    if sys.stderr.isatty():
        print(f"\r\033[K{text}", end="" if text else "\r", file=sys.stderr, flush=True)
    elif text:
        print(text, file=sys.stderr, flush=True)


def tell_step(text: str) -> None:
    """The same of one of many short steps: without a terminal only now and then."""
    global _told_step_s
    if not sys.stderr.isatty():
        if time.monotonic() - _told_step_s < STEPS_PAUSE_S:
            return
        _told_step_s = time.monotonic()
    tell(text)
