# SPDX-License-Identifier: Apache-2.0
"""The control framework: times of ticks, leaks between priorities, torque jumps, contact through each interface."""

from __future__ import annotations

from typing import Any

from robotskin.errors import UnknownNameError
from robotskin_lab.bench import (
    control_fallback,
    control_interfaces,
    control_map,
    control_peer,
    control_priority,
    control_soak,
    control_switch,
    control_ticks,
)

PARTS = ("ticks", "skin", "peer", "priority", "fallback", "switch", "map", "spread", "collision", "proximity", "soak")


def run(
    *,
    seed: int = 1,
    parts: str = ",".join(PARTS),
    ticks: int = 20000,
    states: int = 10000,
    pushed_cells: int = 10,
    soak_seconds: float = 600.0,
    tsid_python: str = "",
) -> dict[str, Any]:
    """Measure the parts named in `parts`, with commas between them; a part that is left out leaves its keys out.

    `ticks` periods a timed stack, `states` random states for the leaks, `pushed_cells` cells pushed with 5, 15 and 30 N
    through each interface, `soak_seconds` for every behaviour on each of three robots. `tsid_python` is the Python of
    an environment that has TSID (else ROBOTSKIN_TSID_PYTHON): without one, the figures of that peer are absent.
    """
    wanted = [part.strip() for part in parts.split(",")]
    for part in wanted:
        if part not in PARTS:
            raise UnknownNameError("part of bench control", part, PARTS)
    measure = {
        "ticks": lambda: control_ticks.tick_figures(seed, ticks),
        "skin": lambda: control_ticks.skin_figures(seed, ticks),
        "peer": lambda: control_peer.peer_figures(seed, ticks, tsid_python),
        "priority": lambda: control_priority.priority_figures(seed, states),
        "fallback": lambda: control_fallback.fallback_figures(seed, max(states // 20, 5)),
        "switch": lambda: control_switch.switch_figures(seed),
        "map": lambda: control_map.map_figures(seed),
        "spread": lambda: control_interfaces.spread_figures(seed, pushed_cells),
        "collision": lambda: control_interfaces.collision_figures(seed),
        "proximity": lambda: control_interfaces.proximity_figures(seed),
        "soak": lambda: control_soak.soak_figures(seed, soak_seconds),
    }
    figures: dict[str, Any] = {}
    for part in wanted:
        figures |= measure[part]()
    return figures | control_ticks.ratio_figures(seed, figures)
