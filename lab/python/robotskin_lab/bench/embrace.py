# SPDX-License-Identifier: Apache-2.0
"""Embraces (V-C, V-D): a humanoid hugs a soft person, and draws large things to its chest; baselines beside."""

from __future__ import annotations

import dataclasses
import time
from pathlib import Path
from typing import Any

import numpy as np

from robotskin.apps.embrace.scene import Person
from robotskin.apps.embrace.script import hug_limits, session_of
from robotskin.apps.embrace.script import run as hug
from robotskin.errors import UnknownNameError
from robotskin_lab.bench.count import Count
from robotskin_lab.bench.embrace_grasps import WAYS, draw_first_grasp, grasp_figures
from robotskin_lab.bench.embrace_picture import draw_hug, followed_hug
from robotskin_lab.bench.progress import tell, tell_step

HUGS = ("hug", "stiff")
PARTS = (*HUGS, *WAYS)
KEPT = (
    "hug_active_cells",
    "hug_cell_max_n",
    "in_contact",
    "person_moved_mm",
    "still_held",
    "let_go",
    "stands",
    "running",
    "region_chest_true_n",
    "region_back_true_n",
)
"""Of each part; the figures of the other parts have its name before theirs."""


def run(
    *,
    seed: int = 1,
    parts: str = "hug,stiff,grasp,by_map,open_loop,masked",
    objects: Count = 6,
    objects_beside: Count = 6,
    seeds: Count = 1,
    picture: Path | None = None,
    grasp_picture: Path | None = None,
) -> dict[str, Any]:
    """Measure the parts named in `parts`, with commas between them: hugs of a drawn person, grasps of drawn things.

    Of each of `seeds` seeds, from `seed` on, `objects` things by the skin and `objects_beside` in each other way: what
    is told of a way is pooled over them. Hugs are of the first seed alone. The whole: `robotskin reproduce embrace
    large_things`.

    hug: arms that answer to the skin. stiff: arms that close to where a person 250 mm deep would be held, and
    no limit of contact that would stop them. grasp: large
    things, by the skin, on a fixed base. by_map: the same things, where touched cells give way by a sensory-motor map
    that the skin has learnt, in place of the model; `by_map_below_model` is the share of things that it holds less than
    grasp. no_reaction: they do not give way, and paths alone adapt. open_loop: on the path of a thing of 0.35 m.
    masked: with all cells left out. standing: on the robot's own feet. taught: on paths
    that a scripted person taught by hand, in one lesson a seed. picture, grasp_picture: where the hug, and the
    grasp of the first thing, are drawn.
    """
    wanted = [part.strip() for part in parts.split(",")]
    for part in wanted:
        if part not in PARTS:
            raise UnknownNameError("part of bench embrace", part, PARTS)
    generator = np.random.default_rng([seed, 18])
    person = Person.drawn(generator)
    along = float(generator.choice([90.0, -90.0]))
    figures: dict[str, Any] = {"person_depth_mm": 1e3 * person.depth_m, "person_n_per_m": person.stiffness_n_per_m}
    began = time.process_time()
    for part in [one for one in wanted if one in WAYS]:
        things = objects if part == "grasp" else objects_beside
        found = grasp_figures(part, range(seed, seed + seeds), things)
        figures |= found if part == "grasp" else {f"{part}_{name}": value for name, value in found.items()}
    if {"grasp", "by_map"} <= set(wanted):
        figures["by_map_below_model"] = figures["success_share"] - figures["by_map_success_share"]
    for part in [one for one in wanted if one in HUGS]:
        tell_step(f"{part}: a person {1e3 * person.depth_m:.0f} mm deep")
        # The limits are the skin's: they would hold stiff arms where they first press too hard.
        limits = hug_limits() if part == "hug" else dataclasses.replace(hug_limits(), regions=())
        session = session_of(person, seed, limits)
        try:
            session.boot()
            kept = followed_hug()
            look = kept.look if part == "hug" and picture is not None else lambda _watch: None
            found = hug(session, regulated=part == "hug", along_deg=along, progress=kept.progress, look=look)
        finally:
            session.shut_down()
        if part == "hug" and picture is not None:
            draw_hug(picture, kept, person)
        figures |= found if part == "hug" else {f"{part}_{name}": found[name] for name in (*KEPT, "sensors_at_end")}
    if grasp_picture is not None:
        tell_step("picture of a grasp")
        draw_first_grasp(grasp_picture, seed)
    tell("")
    return figures | {"processor_s": time.process_time() - began}
