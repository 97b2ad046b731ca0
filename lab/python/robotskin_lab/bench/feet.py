# SPDX-License-Identifier: Apache-2.0
"""`robotskin bench feet`: what soles of seven cells tell of an exoskeleton's steps, sound and worn."""

from __future__ import annotations

import time
from typing import Any

import numpy as np

from robotskin.apps.feet.exoskeleton import REGIONS
from robotskin.apps.feet.gait import Gait
from robotskin.apps.feet.script import expected_duty, figures_of, walk
from robotskin.apps.feet.settings import read_settings
from robotskin.apps.feet.walk import FeelingFeet
from robotskin_lab.bench.count import Count
from robotskin_lab.bench.feet_losses import losses
from robotskin_lab.bench.progress import tell, tell_step

SETTLES_S = 0.6
WORSE_IF_LARGE = (
    *("false_share", "taken_back_share", "wrong_share", "scuffs_reported_share"),
    *("latency_ms", "lift_off_ms", "duty_", "silent_ms", "motors_"),
)


def run(*, seed: int = 1, seeds: Count = 1, steps: Count = 500) -> dict[str, Any]:
    """Walk on sound soles; walk on with one dead cell a sole; then lose the cells of a region, a sole, or both soles.

    Everything goes through firmware, network and driver, in the imperfect world. Of several seeds the worst counts, and
    the best for the threshold that stands beside.
    `worn_` figures are of the second walk, whose cells have drifted since the first one began: at the usual 500 steps
    for ten minutes. `naive_` ones are of a threshold of 0.3 N on the strongest cell. Cells are lost in short walks of
    their own (`feet_losses.py`).

    Args:
        seed: of gait and world; the first of `seeds`.
        seeds: how many are run.
        steps: of each of the two walks.
    """
    began = time.process_time()
    figures: dict[str, Any] = {}
    for one in range(seed, seed + seeds):
        found = _figures(one, steps)
        for name, value in found.items():
            large = any(part in name for part in WORSE_IF_LARGE)
            counts = max if large != ("naive_" in name) else min  # of the baseline the best seed
            figures[name] = counts(figures.get(name, value), value)
    tell("")
    return figures | {"seeds": seeds, "processor_s": time.process_time() - began}


def _figures(seed: int, steps: int) -> dict[str, float]:
    gait = Gait(seed, 2 * steps)
    feet = FeelingFeet(gait, read_settings(), seed)
    expected = expected_duty(feet)

    def progress(text: str) -> None:
        tell_step(f"feet: seed {seed}, {text}")

    sound = walk(feet, gait.steps[steps].lifts_s - SETTLES_S, expected, progress)
    figures = figures_of(feet, sound, gait.steps[:steps])
    draw = np.random.default_rng([seed, 5])
    for foot in range(2):
        feet.world.network.kill(7 * foot + int(draw.integers(len(REGIONS))))
    worn = walk(feet, gait.ends_s, expected, progress)
    figures |= {f"worn_{name}": value for name, value in figures_of(feet, worn, gait.steps[steps:]).items()}
    return figures | losses(seed, progress)
