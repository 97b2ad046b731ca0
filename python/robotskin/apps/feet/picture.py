# SPDX-License-Identifier: Apache-2.0
"""Two steps, drawn: what the cells felt, what was told of each foot, and what the three motors did."""

from __future__ import annotations

import itertools
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from robotskin.apps.feet.exoskeleton import REGIONS, SIDES, Region
from robotskin.apps.feet.gait import Step
from robotskin.apps.feet.script import Walked
from robotskin.apps.feet.truth import LOADED_N
from robotskin.apps.feet.walk import FeelingFeet
from robotskin.errors import InputError

if TYPE_CHECKING:
    from matplotlib.axes import Axes

Array = NDArray[np.float64]
COLOURS = {Region.FRONT: "#0072b2", Region.CENTRE: "#d55e00", Region.BACK: "#009e73"}
"""Of Okabe and Ito (2008), which eyes of every kind tell apart."""
MARKS = {"touchdown": "v", "lift-off": "^", "scuff": "X", "announced": "o", "taken back": "s", "stays": "D"}
BEFORE_S, AFTER_S = 0.35, 0.75
"""The first of the two steps and the second one."""


def draw(feet: FeelingFeet, walked: Walked, file: Path) -> None:
    """Draw the first two steps in a row of which one scuffs; without a scuff the first two.

    Args:
        feet: that walked.
        walked: what was taken down.
        file: a picture, such as `feet.png`; its ending names the kind.

    Raises:
        InputError: the file cannot be written.
    """
    from matplotlib.figure import Figure

    first, second = _steps(feet.gait.steps)
    begins, ends = first.lifts_s - BEFORE_S, second.lands_s + AFTER_S
    time = np.array(walked.time_s)
    shown = (time >= begins) & (time <= ends)
    figure = Figure(figsize=(9.0, 7.6), layout="constrained")
    axes = figure.subplots(2 + len(Region), 1, sharex=True, height_ratios=[3, 3, *[1] * len(Region)])
    for foot, axis in enumerate(axes[:2]):
        _draw_foot(axis, feet, walked, foot, shown)
    for region, axis in zip(Region, axes[2:], strict=True):
        _draw_motor(axis, walked, region, shown)
    axes[-1].set_xlim(begins, ends)
    axes[-1].set_xlabel("time, s")
    try:
        figure.savefig(file, dpi=110)
    except (OSError, ValueError) as error:
        raise InputError(f"picture {file}: {error}") from error


def _steps(steps: list[Step]) -> tuple[Step, Step]:
    # With the first two steps the wearer begins to walk.
    pairs = list(itertools.pairwise(steps[2:])) or [(steps[0], steps[1])]
    return next((pair for pair in pairs if any(step.scuff for step in pair)), pairs[0])


def _draw_foot(axis: Axes, feet: FeelingFeet, walked: Walked, foot: int, shown: NDArray[np.bool_]) -> None:
    time = np.array(walked.time_s)[shown]
    felt_n = np.array(walked.cell_n)[shown, 7 * foot : 7 * foot + 7]
    loaded = np.array(walked.load_n)[shown, foot].sum(axis=1) > LOADED_N
    top = 1.75 * max(float(felt_n[:, region == REGIONS].sum(axis=1).max()) for region in Region)
    axis.fill_between(time, 0, top, where=loaded, color="0.92", step="post", label="truly on the ground")
    for region in Region:
        axis.plot(time, felt_n[:, region == REGIONS].sum(axis=1), color=COLOURS[region], label=region.name.lower())
    events = [event for event in feet.told[foot].events if time[0] <= event.time_s <= time[-1]]
    for event in events:
        axis.axvline(event.time_s, color="0.35", linewidth=0.8, linestyle=":")
        place = event.time_s, 0.98 * top
        axis.plot(*place, MARKS.get(event.kind, "*"), color="black", markersize=6)
        axis.annotate(event.kind, place, xytext=(3, -7), textcoords="offset points", rotation=90, va="top", fontsize=9)
    axis.set_ylim(0, 1.08 * top)
    axis.set_ylabel(f"{SIDES[foot]} sole: force on cells, N")
    axis.legend(loc="center left", bbox_to_anchor=(1.0, 0.5), fontsize=9, frameon=False)


def _draw_motor(axis: Axes, walked: Walked, region: Region, shown: NDArray[np.bool_]) -> None:
    time = np.array(walked.time_s)[shown]
    duty, strength = np.array(walked.duty)[shown, region], np.array(walked.strength)[shown, region]
    axis.fill_between(
        time, 0, duty, step="post", color=COLOURS[region], alpha=0.35, label=f"{region.name.lower()}: duty"
    )
    axis.plot(time, strength, color=COLOURS[region], linewidth=1.0, label="speed of the motor")
    axis.set_ylim(0, 1.05)
    axis.set_yticks([0, 1])
    axis.legend(loc="center left", bbox_to_anchor=(1.0, 0.5), fontsize=9, frameon=False)
