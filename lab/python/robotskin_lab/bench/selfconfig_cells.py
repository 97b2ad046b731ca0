# SPDX-License-Identifier: Apache-2.0
"""`robotskin bench selfconfig`, cells: how far those of a UR5 are placed off, in the imperfect world and the ideal one.

Through firmware, network, driver and guard; nothing but the world knows the layout.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import pairwise

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


POOLED = ("nees_within_95", "configure_stated_over_error_mm", "configure_stated_over_error_deg")
"""Beside the worst seed stands what all seeds give together: cells of a link share much of their error."""


def cell_figures(seeds: Sequence[int]) -> Figures:
    """The worst of the seeds, in the imperfect world; the same keys with `_ideal` in the ideal one.

    With `_pooled`: over the cells of all seeds. `nees_patches_below`: share of all patches of which fewer than 0.9 of
    the cells are within their 95 %. `configure_error_alike`: correlation between the errors of place of the same cells
    in two skins, the median over patches and axes; all skins have one layout, so this is what the layout itself does.
    """
    figures: Figures = {}
    for ideal, suffix in ((False, ""), (True, "_ideal")):
        placed = [placed_once(seed, ideal) for seed in seeds]
        runs = [figures_of(one) for one in placed]
        for key in runs[0]:
            worst = min if key in LEAST else max
            figures[key + suffix] = worst(run[key] for run in runs)
        figures[f"nees_within_95_most{suffix}"] = max(run["nees_within_95"] for run in runs)
        patches = [patch for one in placed for patch in one]
        pooled = figures_of(patches)
        figures |= {f"{key}_pooled{suffix}": pooled[key] for key in POOLED}
        within = [patch.within().mean() for patch in patches]
        figures[f"nees_patches_below{suffix}"] = float(np.mean([share < PATCH_WITHIN for share in within]))
        figures[f"nees_patches{suffix}"] = float(len(within))
        if len(placed) > 1:
            figures[f"configure_error_alike{suffix}"] = _alike(placed)
    return figures


PATCH_WITHIN = 0.9
ALIKE_CELLS = 20
"""Of fewer cells a correlation tells nothing."""


def _alike(placed: Sequence[Sequence[PlacedPatch]]) -> float:
    found = []
    for one, next_one in pairwise(placed):
        for first in one:
            same = [second for second in next_one if np.array_equal(first.key, second.key)]
            if len(first.key) >= ALIKE_CELLS and same:
                shifts = zip(first.error[:, 3:].T, same[0].error[:, 3:].T, strict=True)
                found += [np.corrcoef(ours, theirs)[0, 1] for ours, theirs in shifts]
    return float(np.median(found))


def placed_once(seed: int, ideal: bool) -> list[PlacedPatch]:
    """One babbling of a UR5, configured, against the truth."""
    robot, layout = load("ur5"), finished("ur5")
    with ideal_world(ideal):
        recording = babble(robot, layout, seed)
    return placed_against(layout, configure(robot, recording))


@dataclass
class PlacedPatch:
    """The cells of a patch that was placed."""

    key: NDArray[np.int64]
    """(N)."""
    error: NDArray[np.float64]
    """(N, 6) rad and m by which each is turned and off."""
    covariance: NDArray[np.float64]
    """(N, 6, 6) as stated."""

    def within(self) -> NDArray[np.bool_]:
        """(N) whether the error is within the 95 % that are stated."""
        squares = np.einsum("ni,nij,nj->n", self.error, np.linalg.inv(self.covariance), self.error)
        return squares <= chi2.ppf(0.95, 6)


def placed_against(layout: Layout, found: Configuration) -> list[PlacedPatch]:
    """Errors of all placed cells and what is stated of them, by patch.

    Args:
        layout: as the skin truly sits.
        found: by the skin.
    """
    patches = []
    for patch in found.patches:
        if patch.placed:
            cells = np.asarray(found.topology.cell[patch.cells], np.int64)
            true = layout.link_from_cell[layout.cells_of(cells)]
            error = np.concatenate(pose_errors(patch.link_from_cell(), true), axis=1)
            patches.append(PlacedPatch(cells, error, patch.covariance()))
    assert sum(len(patch.error) for patch in patches) == len(cells_in(layout, found.layout()))
    return patches


def figures_of(patches: Sequence[PlacedPatch]) -> Figures:
    """Of all their cells: how far off, and whether what is stated of that is honest."""
    error = np.concatenate([patch.error for patch in patches])
    covariance = np.concatenate([patch.covariance for patch in patches])
    within = np.concatenate([patch.within() for patch in patches])
    turn_deg, shift_mm = np.degrees(_length(error[:, :3])), 1e3 * _length(error[:, 3:])
    stated_deg = np.degrees(_deviation(covariance[:, :3, :3]))
    stated_mm = 1e3 * _deviation(covariance[:, 3:, 3:])
    return {
        "configure_cells_placed": len(error),
        "configure_cell_mm": float(np.median(shift_mm)),
        "configure_cell_p95_mm": float(np.quantile(shift_mm, 0.95)),
        "configure_cell_deg": float(np.median(turn_deg)),
        "configure_cell_p95_deg": float(np.quantile(turn_deg, 0.95)),
        "nees_within_95": float(within.mean()),
        "configure_stated_over_error_mm": float(np.median(stated_mm) / np.median(shift_mm)),
        "configure_stated_over_error_deg": float(np.median(stated_deg) / np.median(turn_deg)),
    }


def _length(vectors: NDArray[np.float64]) -> NDArray[np.float64]:
    return np.linalg.norm(vectors, axis=1)


def _deviation(covariance: NDArray[np.float64]) -> NDArray[np.float64]:
    return np.sqrt(np.trace(covariance, axis1=1, axis2=2))
