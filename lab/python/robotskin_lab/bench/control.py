# SPDX-License-Identifier: Apache-2.0
"""The control framework: times of ticks, leaks between priorities, torque jumps, contact through each interface."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

from robotskin.control import BEHAVIOURS
from robotskin.errors import UnknownNameError
from robotskin_lab.bench import (
    control_collision,
    control_fallback,
    control_map,
    control_peer,
    control_priority,
    control_proximity,
    control_soak,
    control_spread,
    control_switch,
    control_ticks,
)
from robotskin_lab.bench.count import Count

PARTS = ("ticks", "skin", "peer", "priority", "fallback", "switch", "map", "spread", "collision", "proximity", "soak")

MORE_IS_BETTER = (
    "_agreement", "_agreement_without_model", "_cosine", "_cosine_without_model", "_touches", "_touches_without_model",
    "_slope_ok", "proximity_contact_free", "proximity_balls", "proximity_least_gap_mm", "proximity_retreat_mm",
    "push_peak_force_stiff_n", "push_peak_cell_share", "interface_pushes", "fallback_cut_ticks", "priority_states",
    "soak_s", "soak_touches", "flat_qp_limited_share",
)  # fmt: skip
"""Ends of keys, but for `_ideal`, of which the least of all seeds is the worst, such as how much was looked at."""


def run(
    *,
    seed: int = 1,
    parts: str = ",".join(PARTS),
    ticks: Count = 20000,
    states: Count = 10000,
    pushed_cells: Count = 10,
    soak_seconds: float = 600.0,
    soak_behaviours: str = ",".join(BEHAVIOURS),
    seeds: Count = 1,
    tsid_python: str = "",
) -> dict[str, Any]:
    """Measure the parts named in `parts`, with commas between them; a part that is left out leaves its keys out.

    Of several `seeds`, from `seed` on, each key is the worst.

    `ticks` periods a timed stack, `states` random states for the leaks, `pushed_cells` cells pushed with 5, 15 and 30 N
    through each interface, `soak_seconds` for each of `soak_behaviours` on each of three robots. `tsid_python` is the
    Python of an environment that has TSID (else ROBOTSKIN_TSID_PYTHON): without one, the figures of that peer are
    absent.
    """
    wanted = [part.strip() for part in parts.split(",")]
    for part in wanted:
        if part not in PARTS:
            raise UnknownNameError("part of bench control", part, PARTS)
    soaked = [name.strip() for name in soak_behaviours.split(",")]
    for name in soaked:
        if name not in BEHAVIOURS:
            raise UnknownNameError("behaviour", name, BEHAVIOURS)
    by_seed = [
        _of_seed(number, wanted, ticks, states, pushed_cells, soak_seconds, soaked, tsid_python)
        for number in range(seed, seed + seeds)
    ]
    return worst_of(by_seed) | {"seeds": float(seeds)}


def worst_of(by_seed: Sequence[dict[str, Any]]) -> dict[str, Any]:
    """For each figure the most of all seeds, or the least where more is better; text: the first seed's."""

    def worst(key: str, value: Any) -> Any:
        if not isinstance(value, int | float):
            return value
        values = [one[key] for one in by_seed]
        return min(values) if key.removesuffix("_ideal").endswith(MORE_IS_BETTER) else max(values)

    return {key: worst(key, value) for key, value in by_seed[0].items()}


def _of_seed(
    seed: int,
    wanted: list[str],
    ticks: int,
    states: int,
    pushed_cells: int,
    soak_seconds: float,
    soaked: list[str],
    tsid_python: str,
) -> dict[str, Any]:
    measure = {
        "ticks": lambda: control_ticks.tick_figures(seed, ticks),
        "skin": lambda: control_ticks.skin_figures(seed, ticks),
        "peer": lambda: control_peer.peer_figures(seed, ticks, tsid_python),
        "priority": lambda: control_priority.priority_figures(seed, states),
        "fallback": lambda: control_fallback.fallback_figures(seed, max(states // 20, 5)),
        "switch": lambda: control_switch.switch_figures(seed),
        "map": lambda: control_map.map_figures(seed),
        "spread": lambda: control_spread.spread_figures(seed, pushed_cells),
        "collision": lambda: control_collision.collision_figures(seed),
        "proximity": lambda: control_proximity.proximity_figures(seed),
        "soak": lambda: control_soak.soak_figures(seed, soak_seconds, behaviours=soaked),
    }
    figures: dict[str, Any] = {}
    for part in wanted:
        figures |= measure[part]()
    return figures | control_ticks.ratio_figures(seed, figures)
