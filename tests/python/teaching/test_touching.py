# SPDX-License-Identifier: Apache-2.0
"""What a squeeze tells: the stiffness of the thing, whatever number of cells of each pad carries."""

import numpy as np
import pytest

from robotskin.teaching.touching import Squeezed

SKIN_N_PER_M = 3750.0  # both pads, one cell each
CELL_N_PER_M = 2 * SKIN_N_PER_M


def squeezed(stiffness_n_per_m: float, cells: tuple[int, int], force_n: np.ndarray) -> Squeezed:
    """Springs in series: the thing, and of each pad as many cells beside each other as carry."""
    gives = 1.0 / stiffness_n_per_m + sum(1.0 / (number * CELL_N_PER_M) for number in cells)
    return Squeezed([float(0.06 - gives * one) for one in force_n], force_n.tolist(), [cells] * len(force_n))


@pytest.mark.parametrize("cells", [(1, 1), (2, 1), (1, 2), (2, 2), (3, 2)])
def test_the_skin_of_all_cells_that_carry_is_taken_out(seed: int, cells: tuple[int, int]) -> None:
    stiffness = float(np.random.default_rng(seed).uniform(2000, 12000))
    found = squeezed(stiffness, cells, np.linspace(1.6, 6.4, 60))
    assert found.stiffness_n_per_m(SKIN_N_PER_M) == pytest.approx(stiffness, rel=1e-6)


def test_a_cell_that_comes_to_carry_does_not_bend_the_slope() -> None:
    early, late = squeezed(6000, (1, 1), np.linspace(1.6, 3.0, 20)), squeezed(6000, (2, 1), np.linspace(3.0, 6.4, 60))
    both = Squeezed(
        [*early.width_m, *(width - late.width_m[0] + early.width_m[-1] for width in late.width_m)],
        early.force_n + late.force_n,
        early.carrying + late.carrying,
    )
    assert both.stiffness_n_per_m(SKIN_N_PER_M) == pytest.approx(6000, rel=1e-6)


def test_a_squeeze_that_felt_too_little_tells_nothing() -> None:
    assert np.isnan(Squeezed().stiffness_n_per_m(SKIN_N_PER_M))
    assert np.isnan(squeezed(6000, (1, 1), np.linspace(0.1, 1.4, 60)).stiffness_n_per_m(SKIN_N_PER_M))
    assert np.isnan(squeezed(6000, (1, 1), np.linspace(2.0, 2.5, 60)).slope_n_per_m)
