# SPDX-License-Identifier: Apache-2.0
"""A generated gait: where both feet are told to be, drawn step by step from a seed, with scuffs in some swings."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

import numpy as np
from numpy.typing import NDArray

from robotskin.apps.feet.exoskeleton import HEEL_M, SOLE_Z_M, TOE_M

Array = NDArray[np.float64]
Landing = Literal["flat", "heel", "toe"]

HOVER_M = 0.06
LOWERED_S, STANDS_S, WALKS_S = 1.5, 2.5, 5.0
"""When the feet are lowered, when they stand, when the first one steps."""
CYCLE_S = 2.4
SWING_SHARE = 0.38
STRIDE_M = 0.6
LEG_N_PER_M = 135_000.0
"""Newton of a flat foot for each metre that it is told to be below the ground."""
SCUFF_SHARE = 0.15
UNLOADING_S, PUSH_OFF_S, DIP_S = 0.14, 0.25, 0.22
# What may meet the ground: outermost cells, and the rims of toe and heel beyond them; x and z in the foot's frame.
_POINTS = np.array([[TOE_M, SOLE_Z_M], [HEEL_M, SOLE_Z_M], [0.1355, SOLE_Z_M + 0.0011], [-0.1355, SOLE_Z_M + 0.0011]])


@dataclass(frozen=True)
class Scuff:
    """A toe that touches the ground in the middle of a swing."""

    at_s: float
    hold_s: float
    force_n: float
    pitch_rad: float


@dataclass(frozen=True)
class Step:
    """One swing of one foot, and the stance after it."""

    foot: int
    lifts_s: float
    lands_s: float
    landing: Landing
    pitch_rad: float
    loading_s: float
    load_n: float
    clearance_m: float
    push_off_rad: float
    stride_m: float
    scuff: Scuff | None


class Gait:
    """Steps of both feet in turn, and the joint positions that make them.

    Args:
        seed: repeats it.
        count: steps of both feet together.
        weight_n: what both feet carry.
        scuff_share: of the swings in which the toe touches the ground.
    """

    def __init__(self, seed: int, count: int, weight_n: float = 850.0, scuff_share: float = SCUFF_SHARE) -> None:
        self.weight_n = weight_n
        draw = np.random.default_rng([seed, 17])
        self.steps = [_draw_step(draw, number, weight_n, scuff_share) for number in range(count)]
        self._of_foot = [[step for step in self.steps if step.foot == foot] for foot in (0, 1)]
        self._lifts = [np.array([step.lifts_s for step in steps]) for steps in self._of_foot]
        self._reached = [np.cumsum([0.0] + [step.stride_m for step in steps]) for steps in self._of_foot]
        self.ends_s = WALKS_S + (count + 1) * CYCLE_S / 2
        """When the last step stands."""

    def at(self, time_s: float) -> Array:
        """(6,) joint positions: x, z and pitch of the left foot, then of the right one; metres and rad."""
        return np.concatenate([self._foot(foot, time_s) for foot in (0, 1)])

    def _foot(self, foot: int, time_s: float) -> Array:
        last = int(np.searchsorted(self._lifts[foot], time_s)) - 1
        steps = self._of_foot[foot]
        following = steps[last + 1] if last + 1 < len(steps) else None
        x = self._reached[foot][max(last, 0) + (1 if last >= 0 else 0)]
        if last < 0:
            lowered = _smooth((time_s - LOWERED_S) / (STANDS_S - LOWERED_S))
            low, pitch = HOVER_M - lowered * (HOVER_M + self.weight_n / 2 / LEG_N_PER_M), 0.0
        else:
            low, pitch, x = _after(steps[last], time_s, x)
        if following is not None and (last < 0 or time_s > steps[last].lands_s):
            low *= 1 - _smooth((time_s - following.lifts_s + UNLOADING_S) / UNLOADING_S) if low < 0 else 1.0
            pitch += following.push_off_rad * _smooth((time_s - following.lifts_s + PUSH_OFF_S) / PUSH_OFF_S)
        return np.array([x, low - float((_POINTS[:, 1] * np.cos(pitch) - _POINTS[:, 0] * np.sin(pitch)).min()), pitch])


def _draw_step(draw: np.random.Generator, number: int, weight_n: float, scuff_share: float) -> Step:
    lifts = WALKS_S + (number + draw.uniform(-0.04, 0.04)) * CYCLE_S / 2
    swing = SWING_SHARE * CYCLE_S * draw.uniform(0.92, 1.08)
    landing: Landing = str(draw.choice(["flat", "heel", "toe"], p=[0.5, 0.45, 0.05]))  # type: ignore[assignment]
    pitch = {"flat": (-0.015, 0.015), "heel": (-0.30, -0.10), "toe": (0.04, 0.10)}[landing]
    scuff = None
    if draw.random() < scuff_share:
        at = lifts + swing * draw.uniform(0.35, 0.62)
        scuff = Scuff(at, draw.uniform(0.02, 0.05), draw.uniform(3.0, 15.0), draw.uniform(0.03, 0.14))
    return Step(
        foot=number % 2,
        lifts_s=lifts,
        lands_s=lifts + swing,
        landing=landing,
        pitch_rad=float(draw.uniform(*pitch)),
        loading_s=draw.uniform(0.05, 0.18),
        load_n=weight_n * draw.uniform(0.6, 1.0),
        clearance_m=draw.uniform(0.02, 0.035),
        push_off_rad=draw.uniform(0.10, 0.22),
        stride_m=STRIDE_M / 2 if number < 1 else STRIDE_M,
        scuff=scuff,
    )


def _after(step: Step, time_s: float, x: float) -> tuple[float, float, float]:
    """Height of the lowest point of the foot, its pitch, and its place, after it was lifted."""
    depth = step.load_n / LEG_N_PER_M
    settles = step.loading_s / 3
    if time_s >= step.lands_s:
        since = time_s - step.lands_s
        return -depth * (1 - np.exp(-since / settles)), step.pitch_rad * np.exp(-since / (0.8 * settles)), x
    swing = step.lands_s - step.lifts_s
    s = (time_s - step.lifts_s) / swing
    # It lands as fast as it then loads.
    low = step.clearance_m * np.sin(np.pi * s) ** 2 + depth / settles * swing * (s**2 - s**3)
    pitch = step.push_off_rad * (1 - _smooth(s / 0.35)) + step.pitch_rad * _smooth((s - 0.6) / 0.35)
    if step.scuff is not None:
        away = max(abs(time_s - step.scuff.at_s) - step.scuff.hold_s / 2, 0.0) / (DIP_S / 2)
        share = np.cos(np.pi / 2 * away) ** 2 if away < 1 else 0.0
        low += share * (-step.scuff.force_n / LEG_N_PER_M - low)
        pitch += share * (step.scuff.pitch_rad - pitch)
    return low, pitch, x - step.stride_m * (1 - _quintic(s))


def _smooth(s: float) -> float:
    s = min(max(s, 0.0), 1.0)
    return s * s * (3 - 2 * s)


def _quintic(s: float) -> float:
    s = min(max(s, 0.0), 1.0)
    return s**3 * (10 - 15 * s + 6 * s * s)
