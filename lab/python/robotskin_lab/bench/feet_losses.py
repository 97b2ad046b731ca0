# SPDX-License-Identifier: Apache-2.0
"""How soon the motors of feeling feet are still once cells are lost: of a region, of a sole, of both soles."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
from numpy.typing import NDArray

from robotskin.apps.feet.contact import State
from robotskin.apps.feet.exoskeleton import REGIONS, Region
from robotskin.apps.feet.gait import WALKS_S, Gait
from robotskin.apps.feet.settings import read_settings
from robotskin.apps.feet.walk import FeelingFeet

WATCHED_S = 0.5
"""After the loss; motors that still turn then count as never still."""
FAINT = 0.05
"""Of full speed."""
LOSSES = 4
"""Drawn moments at which each kind of loss strikes."""
SOON_S = 2.4
"""After the drawn moment, in which a foot stands alone and its motors run."""


def losses(seed: int, progress: Callable[[str], None]) -> dict[str, float]:
    """Let cells lose their power at drawn moments of a stance on one foot; the slowest motor of all losses counts.

    Figures are milliseconds from the loss on, in the simulator's time. Until motors that turned are slower than the
    slowest that they can be driven at: `motors_still_ms` after all cells of both soles, `motors_still_one_sole_ms` and
    `motors_still_one_region_ms` after those of the sole or region alone. `motors_faint_ms`: after all cells, until they
    are below 5 % of full speed. `silent_ms`: the slowest of all three kinds, until their duty is 0.

    Args:
        seed: of gaits, worlds and moments.
        progress: takes what is done now.
    """
    draw = np.random.default_rng([seed, 23])
    found: dict[str, float] = {}
    for number in range(LOSSES):
        for kind in ("region", "sole", "all"):
            progress(f"loss {number + 1} of {LOSSES}: {kind}")
            region = Region(int(draw.integers(len(Region))))
            for name, value in _lose(seed, float(draw.uniform(0, 1.2)), kind, region).items():
                found[name] = max(found.get(name, 0.0), value)
    return found


def _lose(seed: int, after_s: float, kind: str, region: Region) -> dict[str, float]:
    """One loss, on feet that walk from the beginning."""
    feet = FeelingFeet(Gait(seed, 6), read_settings(), seed)
    feet.run_until(WALKS_S + after_s)
    foot = _alone(feet, region if kind == "region" else None)
    motors = np.arange(len(Region)) == region if kind == "region" else np.ones(len(Region), dtype=bool)
    cells = np.flatnonzero(region == REGIONS) if kind == "region" else np.arange(len(REGIONS))
    for cell in range(2 * len(REGIONS)) if kind == "all" else 7 * foot + cells:
        feet.world.network.kill(int(cell))
    told_ms, still_ms, faint_ms = _watch(feet, motors)
    if kind == "all":
        return {"silent_ms": told_ms, "motors_still_ms": still_ms, "motors_faint_ms": faint_ms}
    return {"silent_ms": told_ms, f"motors_still_one_{kind}_ms": still_ms}


def _alone(feet: FeelingFeet, region: Region | None) -> int:
    """Walk on until one foot stands alone and its motors, or that of a region, turn; the other foot has just left."""
    until_s = feet.time_s + SOON_S
    while feet.time_s < until_s:
        feet.step()
        states = [contact.state for contact in feet.contacts]
        turns = ~feet.motors.still if region is None else ~feet.motors.still[region]
        if sorted(states) == sorted([State.SWINGS, State.STANDS]) and turns.any():
            foot = states.index(State.STANDS)
            if feet.time_s - feet.contacts[1 - foot].since_s < SOON_S / 8:
                return foot
    raise RuntimeError(f"no motor turned in {SOON_S:g} s of a walk")


def _watch(feet: FeelingFeet, motors: NDArray[np.bool_]) -> tuple[float, float, float]:
    """Milliseconds until all of these motors are told 0, are still, and are faint; inf where they never are."""
    begun = feet.time_s
    told = still = faint = float("inf")
    while feet.time_s < begun + WATCHED_S and faint == float("inf"):
        feet.step()
        passed = 1e3 * (feet.time_s - begun)
        if not feet.motors.duty[motors].any():
            told = min(told, passed)
        if feet.motors.still[motors].all():
            still = min(still, passed)
        if feet.motors.strength[motors].max() < FAINT:
            faint = passed
    return told, still, faint
