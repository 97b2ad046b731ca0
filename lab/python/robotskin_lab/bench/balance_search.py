# SPDX-License-Identifier: Apache-2.0
"""The largest push that a robot stands, looked for from a size that is near it, and at which pushes it was stopped."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

GROWTH = 1.15
"""From one size of a push to the next that is tried, until one stands and the next does not."""


@dataclass(frozen=True)
class Outcome:
    """Of one push. stands: the robot did not fall. stopped: the guard stopped it; it went on balancing."""

    stands: bool
    stopped: bool


@dataclass(frozen=True)
class Found:
    """Sizes in N or N s; 0 where there is none.

    largest: that the robot stood. running: the largest tried that it stood without a stop. stops: pushes that it stood,
    stopped by the guard.
    """

    largest: float
    running: float
    stops: int


def largest_stood(
    push: Callable[[float], Outcome], first: float, most: float, halvings: int, least: float | None = None
) -> Found:
    """The largest size that the robot stands.

    Args:
        push: pushes a new robot with a size.
        first: the size to begin with. most: none beyond it is tried. least: none below it, by default `first` / 12.
        halvings: of the last interval.
    """
    running, stops = 0.0, 0

    def stands(size: float) -> bool:
        nonlocal running, stops
        outcome = push(size)
        if outcome.stands and outcome.stopped:
            stops += 1
        elif outcome.stands:
            running = max(running, size)
        return outcome.stands

    if stands(first):
        low, high = first, first * GROWTH
        while high < most and stands(high):
            low, high = high, high * GROWTH
    else:
        low, high = first / GROWTH, first
        while not stands(low):
            low, high = low / GROWTH, low
            if low < (first / 12 if least is None else least):
                return Found(0.0, 0.0, stops)
    for _ in range(halvings):
        middle = float(np.sqrt(low * high))
        low, high = (middle, high) if stands(middle) else (low, middle)
    return Found(float(low), running, stops)
