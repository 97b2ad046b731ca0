# SPDX-License-Identifier: Apache-2.0
"""Drawn large things taken with both arms (V-C): how many are held, how hard they are pressed, what ends the others."""

from __future__ import annotations

from collections import Counter
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from robotskin.apps.embrace.arms import Paths
from robotskin.apps.embrace.grasp_map import learn_grasp_map
from robotskin.apps.embrace.grasp_scene import Large
from robotskin.apps.embrace.grasp_script import arms_of, grasp_session_of, run_grasp, why_failed
from robotskin.apps.embrace.teach_script import run as teach
from robotskin.selfconfig.map.sensory_motor_map import SensoryMotorMap
from robotskin_lab.bench.embrace_picture import draw_grasp, followed_grasp
from robotskin_lab.bench.progress import tell_step

GRASP = 18, 2
"""Keys of the generator of things: all ways to grasp take the same ones."""
SLID_MM = 5.0
"""Between the forearms: what moves farther has slid."""


@dataclass(frozen=True)
class Way:
    """A way to grasp. reactive: by the skin; masked: all cells are left out; standing: on the robot's own feet.

    by_map: touched cells give way by a map that the skin has learnt, instead of by the model; answers: they do so.
    taught: on paths from a lesson of the same seed, by touch.
    """

    reactive: bool = True
    masked: bool = False
    standing: bool = False
    by_map: bool = False
    answers: bool = True
    taught: bool = False


WAYS = {
    "grasp": Way(),
    "by_map": Way(by_map=True),
    "no_reaction": Way(answers=False),
    "open_loop": Way(reactive=False),
    "masked": Way(masked=True),
    "standing": Way(standing=True),
    "taught": Way(taught=True),
}


def grasp_figures(way: str, seeds: range, objects: int) -> dict[str, float]:
    """Take so many things drawn with each seed, each in a world of its own; figures are pooled over all.

    objects: in all; success_share; peak_arm_n: of the arm that presses harder, which 95 % of grasps stay below;
    peak_cell_n: the largest of all; opened_share: grasps that left the state open; stopped_share: those in
    which the guard stopped the robot, though a thing may be held all the same; false_transition_share: of all
    changes of state, those for which nothing that truly touched gave a reason; failed: by what ended them. For slips
    see `slip_figures`.
    """
    found: list[dict[str, float]] = []
    failed: Counter[str] = Counter()
    how = WAYS[way]
    for seed in seeds:
        if how.by_map:
            tell_step(f"{way}, seed {seed}: the skin learns its map")
        skin_map = learn_grasp_map(seed) if how.by_map else None
        if how.taught:
            tell_step(f"{way}, seed {seed}: both arms are led through their paths")
        taught = teach(seed)[1].paths(arms_of()) if how.taught else None
        generator = np.random.default_rng([seed, *GRASP])
        for number in range(objects):
            large = Large.drawn(generator)
            told = f"thing {number + 1} of {objects}: {large.kind}, {1e3 * large.width_m:.0f} mm"
            tell_step(f"{way}, seed {seed}, {told}")
            found.append(_one(how, large, 1000 * seed + number, skin_map, taught))
            if why := why_failed(found[-1]):
                failed[why] += 1
    column = {name: np.array([one[name] for one in found]) for name in found[0]}
    transitions = float(column["transitions"].sum())
    return {
        "objects": float(len(found)),
        "success_share": float(column["success"].mean()),
        "peak_arm_n": float(np.percentile(column["peak_arm_n"], 95)),
        "peak_cell_n": float(column["peak_cell_n"].max()),
        "grasp_s": float(np.median(column["grasp_s"])),
        "opened_share": float(column["opened"].mean()),
        "stopped_share": float(1 - column["running"].mean()),
        "limit_violations": float(column["limit_violations"].sum()),
        "slips": float(column["slips"].sum()),
        **slip_figures(column["slips"], column["slid_mm"]),
        "false_transition_share": float(column["false_transitions"].sum()) / max(transitions, 1.0),
        "transitions": transitions,
        **{f"failed_{why.replace(',', '').replace(' ', '_')}": float(count) for why, count in sorted(failed.items())},
    }


def slip_figures(slips: NDArray[np.float64], slid_mm: NDArray[np.float64]) -> dict[str, float]:
    """How well slips are felt, of grasps (G,): how often one was felt, and how far the thing truly slid while held.

    slid: things that slid by more than `SLID_MM`; slips_felt_share: of those, the ones with a slip felt, where there
    are any; slips_false: slips felt while things did not slide so far.
    """
    slid = slid_mm > SLID_MM
    share = {"slips_felt_share": float((slips[slid] > 0).mean())} if slid.any() else {}
    return {"slid": float(slid.sum()), **share, "slips_false": float(slips[~slid].sum())}


def draw_first_grasp(file: Path, seed: int) -> None:
    """Take the first thing that is drawn with a seed, by the skin, and draw it; see `draw_grasp`."""
    large, kept = Large.drawn(np.random.default_rng([seed, *GRASP])), followed_grasp()
    session = grasp_session_of(large, 1000 * seed)
    try:
        session.boot()
        run_grasp(session, large, progress=kept.progress, look=kept.look)
    finally:
        session.shut_down()
    draw_grasp(file, kept, large)


def _one(how: Way, large: Large, seed: int, skin_map: SensoryMotorMap | None, taught: Paths | None) -> dict[str, float]:
    """The figures of one grasp."""
    session = grasp_session_of(large, seed, standing=how.standing, skin_map=skin_map, taught=taught)
    try:
        session.boot()
        if how.masked:
            session.leave_out(range(len(session.layout)))
        return run_grasp(session, large, reactive=how.reactive, answers=how.answers, taught=taught)
    finally:
        session.shut_down()
