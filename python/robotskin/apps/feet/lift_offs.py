# SPDX-License-Identifier: Apache-2.0
"""Lift-offs that were told, compared with those that truly happened."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from robotskin.apps.feet.contact import Event
from robotskin.apps.feet.gait import Step
from robotskin.apps.feet.truth import LOADED_N
from robotskin.apps.feet.walk import Told

Array = NDArray[np.float64]
AROUND_S = 0.25
"""Around the time at which a step is planned to leave, in which it truly leaves."""
EARLY_S, LATE_S = 0.10, 0.25
"""Around the true lift-off, in which it has to be told."""
AIR_S = 0.10
"""A foot that has carried nothing for so long is truly in the air."""


def lift_off_figures(time_s: Array, load_n: Array, told: Sequence[Told], steps: Sequence[Step]) -> dict[str, float]:
    """What the soles told of feet that left the ground.

    Figures: `lift_off_detected_share` of the true ones, told and not taken back; `lift_off_ms_median` and
    `lift_off_ms_p99`, after the true one; for each step, `lift_off_false_share`, told without a true one and never
    taken back, `lift_off_taken_back_share`, told and soon taken back by `stays`, and `stays_wrong_share`, told to stay
    while truly in the air.

    Args:
        time_s: (T,) seconds.
        load_n: (T, 2) newton that each foot truly carries.
        told: of both feet.
        steps: whose lift-offs are looked at.
    """
    begins, ends = steps[0].lifts_s - AROUND_S, steps[-1].lands_s + AROUND_S
    delays: list[float] = []
    count = false = taken_back = wrong = 0
    for foot, load in enumerate(load_n.T):
        left = [at for step in steps if step.foot == foot for at in _left(time_s, load, step)]
        count += len(left)
        kept, back = _told(told[foot].events, begins, ends)
        taken_back += len(back)
        near = [[at - true for at in kept if -EARLY_S <= at - true <= LATE_S] for true in left]
        delays += [min(some, key=abs) for some in near if some]
        false += sum(not any(-EARLY_S <= at - true <= LATE_S for true in left) for at in kept)
        stays = [at for at in told[foot].times("stays") if begins <= at <= ends]
        wrong += sum(_in_the_air(time_s, load, at) for at in stays)
    milliseconds = 1e3 * np.array(delays or [np.inf])
    return {
        "lift_off_detected_share": len(delays) / max(count, 1),
        "lift_off_ms_median": float(np.median(milliseconds)),
        "lift_off_ms_p99": float(np.percentile(milliseconds, 99)),
        "lift_off_false_share": false / max(len(steps), 1),
        "lift_off_taken_back_share": taken_back / max(len(steps), 1),
        "stays_wrong_share": wrong / max(len(steps), 1),
    }


def _left(time_s: Array, load_n: Array, step: Step) -> list[float]:
    """When the foot truly left: the last moment under load around the planned one; none if it never carried any."""
    loaded = np.flatnonzero((np.abs(time_s - step.lifts_s) < AROUND_S) & (load_n > LOADED_N))
    return [float(time_s[loaded[-1]])] if len(loaded) else []


def _told(events: Sequence[Event], begins_s: float, ends_s: float) -> tuple[list[float], list[float]]:
    """The lift-offs that stand, and those that the next word on the foot takes back."""
    words = [event for event in events if event.kind in ("lift-off", "stays", "touchdown", "not heard")]
    kept: list[float] = []
    back: list[float] = []
    for event, after in zip(words, [*words[1:], None], strict=True):
        if event.kind == "lift-off" and begins_s <= event.time_s <= ends_s:
            (back if after is not None and after.kind == "stays" else kept).append(event.time_s)
    return kept, back


def _in_the_air(time_s: Array, load_n: Array, at_s: float) -> bool:
    """Whether the foot carried nothing just before."""
    before = (time_s > at_s - AIR_S) & (time_s <= at_s)
    return bool(before.any() and (load_n[before] <= LOADED_N).all())
