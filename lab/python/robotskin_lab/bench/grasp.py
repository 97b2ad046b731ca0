# SPDX-License-Identifier: Apache-2.0
"""Reactive grasping (V-B): what is held, what was pushed before all fingers touched; simpler grasps beside it."""

from __future__ import annotations

import time
from pathlib import Path
from typing import Any

import numpy as np

from robotskin.apps.grasp.control import Method
from robotskin.apps.grasp.scene import OBJECTS, PLIERS, Trial
from robotskin.apps.grasp.script import TIPS_WITH_BACKS, Plan, session_of
from robotskin.apps.grasp.script import run as grasp
from robotskin.errors import InputError, UnknownNameError
from robotskin_lab.bench.grasp_picture import draw_grasps, followed
from robotskin_lab.bench.grasp_soak import soak_figures
from robotskin_lab.bench.progress import tell, tell_step

ON_ARM = ("arm", "arm_primitive")
SOAK = "soak"
PARTS = ("reactive", "equal", "primitive", "exact", "hold", *ON_ARM, SOAK)
WITHOUT = {PLIERS: ("primitive", "exact", *ON_ARM), "ball": ("equal",), "cylinder": ("equal",)}
"""The parts that an object has no part in."""
METHODS: dict[str, Method] = {
    "primitive": "primitive",
    "exact": "primitive",
    "arm_primitive": "primitive",
    "equal": "equal",
}
CLOSED_MM, TURNED_DEG, TURNED_FAR_DEG = 1.0, 3.0, 5.0
SHORT = {"hold_s": 1.0, "shake_s": 0.0, "touch_n": 0.0}


def run(
    *,
    seed: int = 1,
    parts: str = "reactive,equal,primitive,exact,hold,arm,arm_primitive",
    objects: str = "ball,cylinder,pliers",
    trials: int = 50,
    pliers_trials: int = 20,
    equal_trials: int = 20,
    primitive_trials: int = 20,
    exact_trials: int = 10,
    hold_trials: int = 10,
    arm_trials: int = 10,
    soak_seconds: float = 600.0,
    least_mm: float = 5.0,
    most_mm: float = 15.0,
    picture: Path | None = None,
) -> dict[str, Any]:
    """Measure the parts named in `parts` on the `objects`, with commas between them.

    reactive, primitive: `trials` and `primitive_trials` with errors between `least_mm` and `most_mm`, ±3 mm of radius
    and an unknown reflectance, each lifted and held for 1 s. exact: the primitive grasp without any error. Pliers are
    up to 10 mm off along their handles: `pliers_trials` reactive, and `equal_trials` with equal forces of the fingers.
    hold: `hold_trials` lifted, held for 5 s, shaken by 0.5 g at 2 Hz for 5 s, and touched on a finger's back with 5 N.
    arm, arm_primitive: `arm_trials` of both grasps with the hand on a UR5, which brings it to the thing and lifts it.
    soak: `soak_seconds` of grasps with touches of up to 5 N on the other cells, and one grasp more without.
    `picture`: where a reactive and a primitive grasp of the same ball are drawn.
    """
    wanted, things = [part.strip() for part in parts.split(",")], [one.strip() for one in objects.split(",")]
    for part in wanted:
        if part not in PARTS:
            raise UnknownNameError("part of bench grasp", part, PARTS)
    for one in things:
        if one not in OBJECTS:
            raise UnknownNameError("object to grasp", one, OBJECTS)
    if not 0 <= least_mm <= most_mm <= 20:
        raise InputError(f"errors between {least_mm:g} and {most_mm:g} mm: they must rise and lie within 0 to 20")
    within = (1e-3 * least_mm, 1e-3 * most_mm)
    counts = {"primitive": primitive_trials, "exact": exact_trials, "equal": equal_trials, "hold": hold_trials}
    counts |= dict.fromkeys(ON_ARM, arm_trials)
    figures: dict[str, Any] = {}
    began, simulated = time.process_time(), 0.0
    for name in things:
        counts["reactive"] = pliers_trials if name == PLIERS else trials
        for part in wanted:
            if part in WITHOUT[name]:
                continue
            if part == SOAK:
                figures |= soak_figures(name, seed, soak_seconds)
                continue
            method = METHODS.get(part, "reactive")
            found: list[dict[str, float]] = []
            for index in range(counts[part]):
                tell_step(f"{part} grasp of the {name}: {index + 1} of {counts[part]}")
                generator = np.random.default_rng([seed, index, OBJECTS.index(name)])
                trial = Trial()
                if part != "exact":
                    trial = Trial.drawn_along(generator) if name == PLIERS else Trial.drawn(generator, within)
                long = part == "hold"
                times = {"hold_s": 5.0, "shake_s": 5.0, "touch_n": 5.0} if long else SHORT
                finger = TIPS_WITH_BACKS[index % len(TIPS_WITH_BACKS)]
                robot = "ur5_allegro" if part in ON_ARM else "allegro_grasp"
                plan = Plan(name, method, trial, touched_finger=finger, robot=robot, **times)
                measured, seconds = _one(plan, 1000 * seed + index)
                found.append(measured)
                simulated += seconds
            if found:  # what was not tried has no figure
                figures |= _pooled(part, name, found)
    if simulated:
        figures["realtime_ratio"] = simulated / max(time.process_time() - began, 1e-9)
    if picture is not None:
        trial = Trial.drawn(np.random.default_rng([seed, 99]), (0.010, 0.010))
        draw_grasps(
            picture,
            {
                "by belief alone": followed(Plan("ball", "primitive", trial), seed),
                "by nearness and force": followed(Plan("ball", "reactive", trial), seed),
            },
        )
    tell("")
    return figures


def _one(plan: Plan, seed: int) -> tuple[dict[str, float], float]:
    """The figures of one whole session, and the seconds it lasted."""
    session = session_of(plan, seed)
    try:
        session.boot()
        return grasp(session, plan), session.world.time_s
    finally:
        session.shut_down()


def _pooled(part: str, name: str, found: list[dict[str, float]]) -> dict[str, float]:
    """Shares of all trials, medians and 90 % of what varies, and the worst of what must never be."""

    def values(key: str) -> np.ndarray:
        return np.array([one[key] for one in found])

    label = f"{name}_{part}"
    figures = {
        f"{label}_trials": float(len(found)),
        f"{label}_held": float(values("held").mean()),
        f"{label}_violations": float(values("limit_violations").sum()),
        f"{label}_stops": float((1 - values("running")).sum()),
        f"{label}_lifted_least_mm": float(values("lifted_mm").min()),
    }
    if name == PLIERS:
        gap, turned = values("jaw_gap_mm"), values("turned_deg")
        figures |= {
            f"{label}_closed_and_straight": float(((gap < CLOSED_MM) & (turned < TURNED_DEG)).mean()),
            f"{label}_below_{TURNED_FAR_DEG:g}_deg": float((turned < TURNED_FAR_DEG).mean()),
            f"{label}_jaw_gap_mm": float(gap.max()),
            f"{label}_turned_deg": float(np.median(turned)),
            f"{label}_turned_most_deg": float(turned.max()),
            f"{label}_hinge_error_mm": float(np.median(values("hinge_error_mm"))),
        }
    if part == "hold":
        return figures | {
            f"{label}_slid_mm": float(values("slid_mm").max()),
            f"{label}_touch_gives_mm": float(values("touch_gives_mm").min()),
        }
    if name == PLIERS:
        return figures
    return figures | {
        f"{label}_undisturbed": float(values("undisturbed").mean()),
        f"{label}_moved_mm": float(np.median(values("moved_mm"))),
        f"{label}_moved_90_mm": float(np.quantile(values("moved_mm"), 0.9)),
        f"{label}_force_before_grip_n": float(np.median(values("force_before_grip_n"))),
        f"{label}_force_before_grip_90_n": float(np.quantile(values("force_before_grip_n"), 0.9)),
        f"{label}_force_unevenness": float(np.median(values("force_unevenness"))),
        f"{label}_estimate_error_mm": float(np.median(values("estimate_error_mm"))),
    }
