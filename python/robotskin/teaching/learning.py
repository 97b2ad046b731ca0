# SPDX-License-Identifier: Apache-2.0
"""From demonstrations to a plan: the acts in order, where they part, and the property measured before that decides."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray

from robotskin.teaching.gripper import TeachingError
from robotskin.teaching.plan import FORMAT, Condition, Plan, Step, measured_by
from robotskin.teaching.rules import UNKNOWN, entropy
from robotskin.teaching.signals import Frame

IDLE, LEAVE = "idle", "leave"
"""No acts of a plan: the hand rests; it goes away with nothing in it."""
AT_NO_PLACE = ("release", "squeeze")
PASSING_S = 0.15
"""What was told for a shorter time is no act."""
AGREE = 0.8
"""Share of the demonstrations that a condition must tell rightly: of fewer than five, all."""


@dataclass(frozen=True)
class Act:
    """A run of one activity. at: the place that it was nearest to at its end."""

    do: str
    at: str = ""


@dataclass(frozen=True)
class Demonstration:
    """Acts in order, and the properties of the thing that were measured on the way."""

    acts: tuple[Act, ...]
    measured: dict[str, float]


def acts_of(frames: Sequence[Frame], told: Sequence[str], thing_at: str) -> tuple[Act, ...]:
    """Runs of equal activity, without idling, what is unknown, and what only passed; runs that meet then are one.

    Each is at the place where it ends. A reach, take or put that ends at no place has none.
    """
    runs: list[tuple[str, int, int]] = []
    for number, label in enumerate(told):
        if runs and runs[-1][0] == label:
            runs[-1] = (label, runs[-1][1], number)
        else:
            runs.append((label, number, number))
    lasting = [one for one in runs if frames[one[2]].time_s - frames[one[1]].time_s >= PASSING_S]
    found: list[Act] = []
    for label, _, end in lasting:
        if label in (IDLE, LEAVE, UNKNOWN):
            continue
        at = "" if label in AT_NO_PLACE else frames[end].near
        act = Act(label, "thing" if at == thing_at else at)
        if found and found[-1].do == act.do:
            found.pop()
        found.append(act)
    # What led away from the place of the release, or was no reach because nothing was taken, is no act.
    while found and found[-1].do == "reach":
        found.pop()
    return tuple(found)


def learn_plan(demonstrations: Sequence[Demonstration], taught_with: str) -> Plan:
    """The plan of demonstrations with the same acts, which may differ in the places where things are put.

    Raises TeachingError where the acts differ or ended at no known place, or where nothing measured before tells which
    way they part.
    """
    if not demonstrations:
        raise TeachingError("plan: no demonstration was given")
    first = demonstrations[0].acts
    for number, one in enumerate(demonstrations):
        if [act.do for act in one.acts] != [act.do for act in first]:
            raise TeachingError(
                f"demonstration {number + 1} does {', '.join(act.do for act in one.acts)}, the first one "
                f"{', '.join(act.do for act in first)}: show all of them in the same order"
            )
    if not first:
        raise TeachingError("plan: nothing was done in the demonstrations")
    for number, one in enumerate(demonstrations):
        _require_places(one, number + 1)
    steps: list[Step] = []
    known: set[str] = set()
    for number, act in enumerate(first):
        ways = sorted({one.acts[number].at for one in demonstrations})
        if act.do == "put" and ways == [""]:
            continue  # A robot lifts what it has taken by itself.
        if len(ways) == 1:
            steps.append(Step(do=act.do, at=ways[0]))
        elif len(ways) == 2:
            steps += _branch(demonstrations, number, ways, known)
        else:
            raise TeachingError(f"step {act.do!r} goes {len(ways)} ways: {', '.join(ways)}; a plan parts in two")
        known |= measured_by(act.do)
    parted = [str(step.when) for step in steps if step.when is not None]
    about = f"handle each {taught_with}" + (f": {parted[0]}?" if parted else "")
    return Plan(format=FORMAT, version=1, about=about, taught_with=taught_with, steps=tuple(steps))


def _require_places(demonstration: Demonstration, number: int) -> None:
    """Raise TeachingError for an act that needs a place and ended at none; a put without one is the lift."""
    put_at = None
    for act in demonstration.acts:
        if act.do == "reach" and not act.at:
            raise TeachingError(f"demonstration {number}: a reach ended at no known place: show it again")
        if act.do == "put":
            put_at = act.at
        if act.do == "release" and put_at == "":
            raise TeachingError(f"demonstration {number}: the thing was let go at no known place: show it again")


def _branch(demonstrations: Sequence[Demonstration], number: int, ways: list[str], known: set[str]) -> list[Step]:
    """Two steps with conditions on the property that tells the ways apart best; by the widest gap among equals.

    Raises TeachingError where fewer than `AGREE` of the demonstrations went the way that the condition tells.
    """
    best: tuple[float, float, str, float] | None = None
    for name in sorted(known):
        values = sorted((one.measured.get(name, np.nan), one.acts[number].at) for one in demonstrations)
        if any(not np.isfinite(value) or value <= 0 for value, _ in values):
            continue
        for (low, _), (high, _) in pairwise(values):
            threshold = float(np.sqrt(low * high))
            gap = float(np.log(high / low))
            quality = (round(_told_by(values, threshold), 9), gap)
            if best is None or quality > best[:2]:
                best = (*quality, name, threshold)
    if best is None or best[0] <= 0:
        raise TeachingError(
            f"step {demonstrations[0].acts[number].do!r} goes to {' or '.join(ways)}, and nothing measured before "
            f"tells which: {', '.join(sorted(known)) or 'nothing was measured'}"
        )
    _, _, name, threshold = best
    threshold = _between(np.array([one.measured[name] for one in demonstrations]), threshold)
    went = [(one.measured[name] > threshold, one.acts[number].at) for one in demonstrations]
    upper = max(ways, key=lambda way: sum(above is (at == way) for above, at in went))
    lower = next(way for way in ways if way != upper)
    others = [count for count, (above, at) in enumerate(went, 1) if above is not (at == upper)]
    if len(went) - len(others) < AGREE * len(went):
        raise TeachingError(
            f"step {demonstrations[0].acts[number].do!r} goes to {upper} where {name} > {threshold:.4g}, else to "
            f"{lower}; demonstration {', '.join(map(str, others))} of {len(went)} did otherwise: show it again"
        )
    do, threshold = demonstrations[0].acts[number].do, float(f"{threshold:.4g}")
    return [
        Step(do=do, at=upper, when=Condition(property=name, above=threshold)),
        Step(do=do, at=lower, when=Condition(property=name, not_above=threshold)),
    ]


def _between(values: NDArray[np.float64], gap: float) -> float:
    """The middle of what lies below and above a gap, if it lies in the gap: one that stands far out counts less so."""
    below, above = values[values <= gap], values[values > gap]
    middle = float(np.exp(0.5 * (np.log(below).mean() + np.log(above).mean())))
    return middle if below.max() < middle < above.min() else gap


def _told_by(values: list[tuple[float, str]], threshold: float) -> float:
    """Bits that a threshold tells about the way."""

    def counted(part: list[str]) -> dict[str, int]:
        return {way: part.count(way) for way in set(part)}

    parts = [[way for value, way in values if (value > threshold) is above] for above in (True, False)]
    whole = [way for _, way in values]
    return entropy(counted(whole)) - sum(len(part) / len(whole) * entropy(counted(part)) for part in parts if part)
