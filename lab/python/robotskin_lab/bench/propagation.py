# SPDX-License-Identifier: Apache-2.0
"""Force propagation (V-E): how far contacts follow their motion with the arms alone, and with the base behind them."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np

from robotskin.errors import UnknownNameError
from robotskin.tasks import PropagationGains
from robotskin_lab.bench.count import Count
from robotskin_lab.bench.progress import tell, tell_step
from robotskin_lab.bench.propagation_picture import draw_propagation, followed
from robotskin_lab.bench.propagation_rig import VARIANTS, Followed, PropagationRig, drawn_cells
from robotskin_lab.bench.propagation_sessions import session_figures, soak_figures

PARTS = ("range", "merging", "back", "pairs", "sessions", "soak")
FOLLOWED_M = 0.3
REST_M = 0.2
ARM_SUFFICES_M, ARM_SUFFICES_MM = 0.45, 10.0
"""Up to `REST_M` the arm suffices for a cell that arms alone let follow so far, and until there no more than this
behind: an arm whose joint is at its speed limit for a while does not suffice for that while."""


def run(
    *,
    seed: int = 1,
    parts: str = "range,merging,back,pairs,sessions",
    cells: Count = 60,
    seeds: Count = 3,
    cap: float = 0.5,
    session_cells: Count = 6,
    soak_seconds: float = 600.0,
    picture: Path | None = None,
) -> dict[str, Any]:
    """Measure the parts named in `parts`, with commas between them.

    range: `cells` cells of each of `seeds` seeds through the control core, up to `cap` metres, with propagation,
    without it, and by one programme over all joints. merging: contacts of a link apart. back: the base 10 s after the
    release. pairs: two pushes at once. sessions: whole sessions. soak: `soak_seconds` of random touches.
    `picture`: where the run of `robotskin app propagate` is drawn, with arms alone and with the base behind them.
    """
    wanted = [part.strip() for part in parts.split(",")]
    for part in wanted:
        if part not in PARTS:
            raise UnknownNameError("part of bench propagation", part, PARTS)
    drawn = np.concatenate([drawn_cells(seed + index, cells) for index in range(seeds)])
    measure = {
        "range": lambda: range_figures(drawn, cap),
        "merging": lambda: merging_figures(drawn[: max(1, len(drawn) // 6)], cap),
        "back": lambda: back_figures(drawn[: max(1, len(drawn) // 6)], cap),
        "pairs": pair_figures,
        "sessions": lambda: session_figures(seed, session_cells),
        "soak": lambda: soak_figures(seed, soak_seconds),
    }
    figures: dict[str, Any] = {}
    for part in wanted:
        figures |= measure[part]()
    if picture is not None:
        tell_step("picture")
        draw_propagation(
            picture,
            {
                "arms alone": followed(seed, alone=True),
                "arms and base": followed(seed, alone=False),
            },
        )
    tell("")
    return figures


def range_figures(cells: np.ndarray, cap_m: float) -> dict[str, float]:
    """Sums over all cells, never means of ratios: a cell without any range of its own would decide them."""
    found: dict[str, list[Followed]] = {}
    for variant in VARIANTS:
        rig = PropagationRig(variant)
        found[variant] = []
        for index, cell in enumerate(cells):
            tell_step(f"range {variant}: {index + 1} of {len(cells)} cells")
            found[variant].append(rig.follow(int(cell), cap_m))
    ranges = {name: np.array([one.range_m for one in followed]) for name, followed in found.items()}
    rest = np.array([one.base_mm[1] for one in found["with"]])
    far = ranges["without"] >= ARM_SUFFICES_M
    behind = np.array([one.behind_mm[1] for one in found["without"]])
    suffices = far & (behind <= ARM_SUFFICES_MM)
    late = far & (behind > ARM_SUFFICES_MM)
    up = np.array([one.up for one in found["with"]])
    level = up < 0.7
    short = ranges["with"] < FOLLOWED_M
    figures = {
        "cells": float(len(cells)),
        "cap_m": cap_m,
        "range_gain": float(ranges["with"].sum() / ranges["without"].sum()),
        "range_gain_level": float(ranges["with"][level].sum() / max(ranges["without"][level].sum(), 1e-9)),
        "range_gain_one_programme": float(ranges["one programme"].sum() / ranges["without"].sum()),
        "follow_03_without": float((ranges["without"] >= FOLLOWED_M).mean()),
        "follow_03_with": float((ranges["with"] >= FOLLOWED_M).mean()),
        "follow_03_one_programme": float((ranges["one programme"] >= FOLLOWED_M).mean()),
        "range_without_m": float(ranges["without"].mean()),
        "range_with_m": float(ranges["with"].mean()),
        "range_one_programme_m": float(ranges["one programme"].mean()),
        "arm_suffices_cells": float(suffices.sum()),
        "arm_late_cells": float(late.sum()),
        "short_cells_up_median": float(np.median(up[short])) if short.any() else 0.0,
        "violations": float(sum(one.violations for followed in found.values() for one in followed)),
    }
    if suffices.any():
        figures["base_at_rest_mm"] = float(np.nanmax(rest[suffices]))
        figures["base_at_rest_median_mm"] = float(np.nanmedian(rest[suffices]))
    if late.any():
        figures["base_helps_late_arm_mm"] = float(np.nanmax(rest[late]))
    return figures


def merging_figures(cells: np.ndarray, cap_m: float) -> dict[str, float]:
    """The same pushes where contacts of a link that lie 60 mm apart stay two; a single cell's is one in either way."""
    gains = PropagationGains()
    contacts = gains.contacts
    contacts.merge_within_m = 0.06
    gains.contacts = contacts
    together, apart = PropagationRig("with"), PropagationRig("with", gains)
    ranges: dict[str, list[float]] = {"merged": [], "apart": []}
    for cell in cells:
        for name, rig in (("merged", together), ("apart", apart)):
            tell_step(f"merging: cell {cell}, {name}")
            ranges[name].append(rig.follow_pair(int(cell), cap_m))
    return {f"range_two_on_a_link_{name}_m": float(np.mean(values)) for name, values in ranges.items()}


def back_figures(cells: np.ndarray, cap_m: float) -> dict[str, float]:
    """The worst of the base's distances from its place 10 s after the palm has left."""
    rig = PropagationRig("with")
    back = []
    for index, cell in enumerate(cells):
        tell_step(f"back: {index + 1} of {len(cells)} cells")
        rig.follow(int(cell), cap_m)
        back.append(rig.release(10.0))
    return {"base_back_mm": float(max(back))}


def pair_figures() -> dict[str, float]:
    """How far the base has gone along the pushes after 2 s of 6 N each.

    one: on the left shoulder; opposite: on both shoulders against each other; same_side: on both from the front;
    one_limb: on two links of the right arm from the front. As a palm follows its cell, what turns with the arm does.
    """
    rig = PropagationRig("with")
    side, front = np.array([0.0, -1.0, 0.0]), np.array([-1.0, 0.0, 0.0])
    left_out = rig.cell_on("left_shoulder_link", side)
    right_out = rig.cell_on("right_shoulder_link", rig.cell_place(left_out)[:3, 2])
    left_front = rig.cell_on("left_shoulder_link", front)
    right_front = rig.cell_on("right_shoulder_link", front)
    near_elbow = rig.cell_on("right_forearm_link", front)
    figures = {}
    for name, along, pushed in (
        ("one", side, [left_out]),
        ("opposite", side, [left_out, right_out]),
        ("same_side", front, [left_front, right_front]),
        ("one_limb", front, [right_front, near_elbow]),
    ):
        rig.restart()
        for cell in pushed:
            rig.feel(cell, 6.0)
        for _ in range(2000):
            rig.tick()
        figures[f"pair_{name}_base_mm"] = 1e3 * float(along[:2] @ np.asarray(rig.joints.position)[rig.base_joints])
    return figures
