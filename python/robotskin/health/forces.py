# SPDX-License-Identifier: Apache-2.0
"""Zeros of the force sensors, judged while nothing touches a cell, so that no lasting touch is taken for one."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from robotskin.health.evidence import WINDOW_S, Evidence
from robotskin.health.healthy import FORCES
from robotskin.health.kinds import CHANNELS, Finding, Kind

OFFSET_WINDOWS = 8
DRIFT_WINDOWS = 45
DRIFT_AT_LEAST = 10
"""Windows without a touch: a cell in the middle of much handling has few of them, but they reach far."""
DRIFT_ROW = 25
"""Windows in a row whose line is as exact as it must be, at least."""
STRAIGHT_N = 0.02
"""How far from a line a drifting zero may be: a step is none."""


def judged(evidence: Evidence) -> Iterator[Finding]:
    """Force sensors whose zero is wrong or moves."""
    yield from _offset(evidence)
    yield from _drifting(evidence)


def _offset(evidence: Evidence) -> Iterator[Finding]:
    last = evidence.last(OFFSET_WINDOWS)
    free = ~last["touched"] & (last["samples"] > 0)
    enough = free.sum(axis=0) >= OFFSET_WINDOWS // 2
    shown = np.where(free[:, :, None], last["mean"][:, :, FORCES], np.inf).min(axis=0)
    # What a load has left behind comes back by itself.
    bound = evidence.healthy.rest_force_n + evidence.healthy.creep * evidence.crept_n
    wrong = enough[:, None] & np.isfinite(shown) & (shown > bound)
    for cell in np.flatnonzero(wrong.any(axis=1)):
        channels = tuple(CHANNELS[FORCES.start + i] for i in np.flatnonzero(wrong[cell]))
        yield Finding(int(cell), Kind.offset, channels, size=float(shown[cell][wrong[cell]].max()), unit="N")


def _drifting(evidence: Evidence) -> Iterator[Finding]:
    """A line through the untouched windows; slower than it is creep, which ends, and the wave of a healthy zero."""
    last = evidence.last(DRIFT_WINDOWS)
    windows = len(last["time"])
    if windows < DRIFT_ROW:
        return
    free = (~last["touched"] & (last["samples"] > 0))[:, :, None]
    count = free.sum(axis=0)
    time = (last["time"] - last["time"][-1])[:, None, None]
    force = last["mean"][:, :, FORCES].astype(float)
    weight = np.where(free, 1.0, 0.0)
    total = np.maximum(weight.sum(axis=0), 1.0)
    time_mean = (weight * time).sum(axis=0) / total
    force_mean = (weight * force).sum(axis=0) / total
    around = weight * (time - time_mean)
    spread = (around * time).sum(axis=0)
    slope = np.where(spread > 0, (around * force).sum(axis=0) / np.maximum(spread, 1e-9), 0.0)
    off_line = weight * np.abs(force - force_mean - slope * (time - time_mean))
    bent = np.quantile(off_line, 0.9, axis=0)
    healthy = evidence.healthy
    # The windows reach back by half a time constant, when there was more of it.
    creeping = 1.5 * healthy.creep * 60 / healthy.creep_time_s * np.abs(evidence.crept_n - force_mean)
    bound = healthy.drift_n_per_min + creeping
    # The last of the windows must be free, too: nothing is said of a cell that is being touched.
    moves = (np.abs(60 * slope) > bound) & (bent < STRAIGHT_N) & (count >= DRIFT_AT_LEAST)
    moves &= free[-1] & (spread > 0.95 * DRIFT_ROW**3 / 12 * WINDOW_S**2)
    for cell in np.flatnonzero(moves.any(axis=1)):
        channels = tuple(CHANNELS[FORCES.start + i] for i in np.flatnonzero(moves[cell]))
        fastest = float(60 * slope[cell][np.abs(slope[cell]).argmax()])
        yield Finding(int(cell), Kind.drifting, channels, size=fastest, unit="N/min")
