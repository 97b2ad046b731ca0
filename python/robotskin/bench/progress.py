"""Progress of a measurement that takes minutes: one line of the terminal, or a line a step where there is none."""

from __future__ import annotations

import sys


def tell(text: str) -> None:
    """Say what is being measured, on the error stream; "" takes the line away."""
    if sys.stderr.isatty():
        print(f"\r\033[K{text}", end="" if text else "\r", file=sys.stderr, flush=True)
    elif text:
        print(text, file=sys.stderr, flush=True)
