# SPDX-License-Identifier: Apache-2.0
"""Teaching by touch (V-A): fruits told apart by a squeeze, a robot led by its skin, rules, plans and their transfer."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np

from robotskin.errors import UnknownNameError
from robotskin_lab.bench.progress import tell
from robotskin_lab.bench.teaching_rig import Felt, squeezed
from robotskin_lab.bench.teaching_shown import led, told
from robotskin_lab.bench.teaching_soak import led_soak_figures, soak_figures
from robotskin_lab.bench.teaching_sorted import sorted_by_plan
from robotskin_lab.bench.teaching_stacked import stacked

TAUGHT = 5
"""Fruits of each class from which the threshold is learnt."""
RATIOS = (2.0, 1.5, 1.2)


def run(
    *,
    seed: int = 1,
    parts: str = "squeeze",
    fruits: int = 200,
    unseen: int = 20,
    sorted_fruits: int = 20,
    blocks: int = 10,
    soak_seconds: int = 600,
) -> dict[str, Any]:
    """Measure the parts named in `parts`, with commas between them: squeeze, told, led, sorted, stacked, soak and
    led_soak.

    squeeze: `fruits` oranges at each stiffness ratio of 2, 1.5 and 1.2, with 10 % spread, ±1.5 mm of radius, ±3 mm off
    centre, and 10 % of relaxation in 2 s, by a gripper whose arm wears no cells; five of each class are taught. The
    force at a fixed width is the baseline.
    told: rules of four demonstrations by a scripted teacher on `unseen` others, in three styles, and the plans of drawn
    sets of four. Rules that know motion alone are the baseline.
    led: 10 N at the wrist of a robot that is led; beside it one that is not.
    sorted: the plan of four demonstrations on `sorted_fruits` fruits each, at places moved by up to 100 mm: oranges,
    oranges on a Panda, lemons. A demonstration that is played back is the baseline.
    stacked: rules of four demonstrations with fruit, untrained where `blocks` blocks are stacked in three styles. The
    same without what was shown of squeezing are to call it unknown. Rules that know motion alone are the baseline.
    soak: `soak_seconds` of sorting with touches of up to 12 N on the arm, and one fruit more without. led_soak: as many
    of a robot that is led, touched so.
    """
    wanted = [part.strip() for part in parts.split(",")]
    for part in wanted:
        if part not in PARTS:
            raise UnknownNameError("part of bench teaching", part, PARTS)
    counts = {"squeeze": fruits, "told": unseen, "sorted": sorted_fruits, "stacked": blocks}
    counts |= dict.fromkeys(("soak", "led_soak"), soak_seconds)
    figures: dict[str, Any] = {}
    for part in wanted:
        figures |= PARTS[part](seed, counts.get(part, 0))
    tell("")
    return figures


def accuracy(found: list[Felt], value: Callable[[Felt], float]) -> float:
    """The share told apart by a threshold half-way, in ratio, between five taught fruits of each class.

    A fruit that was not measured counts as wrong.
    """
    hard = [value(one) for one in found if one.fruit.hard]
    soft = [value(one) for one in found if not one.fruit.hard]
    taught = [np.nanmean(np.log(np.maximum(each[:TAUGHT], 1e-3))) for each in (hard, soft)]
    threshold = float(np.exp(0.5 * (taught[0] + taught[1])))
    right = [one > threshold for one in hard[TAUGHT:]] + [one <= threshold for one in soft[TAUGHT:]]
    return float(np.mean(right))


def _squeeze(seed: int, fruits: int) -> dict[str, float]:
    figures: dict[str, float] = {"squeeze_fruits": float(fruits)}
    peak = violations = missed = 0.0
    errors: list[float] = []
    for ratio in RATIOS:
        found, broken = squeezed("orange", ratio, 0.10, fruits, seed)
        label = f"{ratio:g}".replace(".", "_")
        figures[f"accuracy_{label}"] = accuracy(found, lambda one: one.stiffness_n_per_m)
        figures[f"fixed_width_{label}"] = accuracy(found, lambda one: one.at_width_n)
        peak = max(peak, *(one.peak_n for one in found))
        violations += broken
        missed += sum(not np.isfinite(one.stiffness_n_per_m) for one in found)
        errors += [one.stiffness_n_per_m / one.fruit.stiffness_n_per_m - 1 for one in found]
    return figures | {
        "peak_force_n": peak,
        "not_measured": missed,
        "stiffness_error": float(np.nanmedian(np.abs(errors))),
        "limit_violations": violations,
    }


PARTS: dict[str, Callable[[int, int], dict[str, float]]] = {
    "squeeze": _squeeze,
    "told": told,
    "led": lambda seed, _count: led(seed),
    "sorted": sorted_by_plan,
    "stacked": stacked,
    "soak": soak_figures,
    "led_soak": led_soak_figures,
}
