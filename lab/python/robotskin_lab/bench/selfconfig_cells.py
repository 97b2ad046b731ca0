# SPDX-License-Identifier: Apache-2.0
"""`robotskin bench selfconfig`, cells: how far those of a UR5 are placed off, in the imperfect world and the ideal one.

Through firmware, network, driver and guard; nothing but the world knows the layout.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray
from scipy.stats import chi2

from robotskin.configuring.configured import babble
from robotskin.layout.finished_layouts import finished
from robotskin.layout.layout import Layout
from robotskin.robots import load
from robotskin.selfconfig.configuration import Configuration
from robotskin.selfconfig.configure import configure
from robotskin.selfconfig.reconstruction.accuracy import pose_errors
from robotskin.session.worn_cells import cells_in
from robotskin.world.ideal import ideal_world

Figures = dict[str, float]

LEAST = ("configure_cells_placed", "nees_within_95")
"""Of these the least over the seeds is the worst; of all others the largest."""


def cell_figures(seeds: Sequence[int]) -> Figures:
    """The worst of the seeds, in the imperfect world; the same keys with `_ideal` in the ideal one."""
    figures: Figures = {}
    for ideal, suffix in ((False, ""), (True, "_ideal")):
        runs = [placed_once(seed, ideal) for seed in seeds]
        for key in runs[0]:
            worst = min if key in LEAST else max
            figures[key + suffix] = worst(run[key] for run in runs)
        figures[f"nees_within_95_most{suffix}"] = max(run["nees_within_95"] for run in runs)
    return figures


def placed_once(seed: int, ideal: bool) -> Figures:
    """One babbling of a UR5, configured, against the truth."""
    robot, layout = load("ur5"), finished("ur5")
    with ideal_world(ideal):
        recording = babble(robot, layout, seed)
    return figures_against(layout, configure(robot, recording))


def figures_against(layout: Layout, found: Configuration) -> Figures:
    """Errors of all placed cells, and whether what is stated of them is honest.

    Args:
        layout: as the skin truly sits.
        found: by the skin.
    """
    errors, covariances = [], []
    key = layout.group.astype(np.int64) << 16 | layout.id
    row = {int(value): number for number, value in enumerate(key)}
    for patch in found.patches:
        if patch.placed:
            true = layout.link_from_cell[[row[int(one)] for one in found.topology.cell[patch.cells]]]
            errors.append(np.concatenate(pose_errors(patch.link_from_cell(), true), axis=1))
            covariances.append(patch.covariance())
    error, covariance = np.concatenate(errors), np.concatenate(covariances)
    assert len(error) == len(cells_in(layout, found.layout()))
    squares = np.einsum("ni,nij,nj->n", error, np.linalg.inv(covariance), error)
    turn_deg, shift_mm = np.degrees(_length(error[:, :3])), 1e3 * _length(error[:, 3:])
    stated_deg = np.degrees(_deviation(covariance[:, :3, :3]))
    stated_mm = 1e3 * _deviation(covariance[:, 3:, 3:])
    return {
        "configure_cells_placed": len(error),
        "configure_cell_mm": float(np.median(shift_mm)),
        "configure_cell_p95_mm": float(np.quantile(shift_mm, 0.95)),
        "configure_cell_deg": float(np.median(turn_deg)),
        "configure_cell_p95_deg": float(np.quantile(turn_deg, 0.95)),
        "nees_within_95": float((squares <= chi2.ppf(0.95, 6)).mean()),
        "configure_stated_over_error_mm": float(np.median(stated_mm) / np.median(shift_mm)),
        "configure_stated_over_error_deg": float(np.median(stated_deg) / np.median(turn_deg)),
    }


def _length(vectors: NDArray[np.float64]) -> NDArray[np.float64]:
    return np.linalg.norm(vectors, axis=1)


def _deviation(covariance: NDArray[np.float64]) -> NDArray[np.float64]:
    return np.sqrt(np.trace(covariance, axis1=1, axis2=2))
