# SPDX-License-Identifier: Apache-2.0
import numpy as np
import pytest

from robotskin.layout import finished
from robotskin.selfconfig.readings.gravity_samples import GravitySamples
from robotskin.selfconfig.reconstruction.accuracy import within_confidence
from robotskin.selfconfig.reconstruction.reconstruction import Reconstruction, reconstruct
from robotskin.selfconfig.simulated.limb import forearm_patch, gravity_readings, random_directions
from robotskin.selfconfig.topology.neighbours import NeighbourLists
from robotskin.selfconfig.topology.topology import explore


@pytest.fixture(scope="module")
def seed(pytestconfig: pytest.Config) -> int:
    return int(pytestconfig.getoption("--seed"))


def on_a_limb(seed: int) -> tuple[Reconstruction, np.ndarray]:
    """The largest patch of the finished UR5, reconstructed, and its true shape."""
    layout, random = finished("ur5"), np.random.default_rng(seed)
    here = layout.patch == np.argmax(np.bincount(layout.patch))
    row = np.cumsum(here) - 1
    neighbours = layout.neighbours[here].copy()
    neighbours[..., 0] = np.where(neighbours[..., 0] >= 0, row[neighbours[..., 0]], -1)
    topology = explore(NeighbourLists.from_indices(np.arange(here.sum()) + 1, neighbours))
    worn = layout.link_from_cell[here]
    felt = gravity_readings(worn, random_directions(random, 8), random)
    shape = reconstruct(topology, GravitySamples.from_raw(felt))
    return shape, np.linalg.inv(worn[shape.root]) @ worn


def test_the_covariance_holds_on_a_lattice_laid_on_a_curved_limb(seed: int) -> None:
    inside, without = [], []
    for number in range(3):
        shape, truth = on_a_limb(seed + number)
        assert 0.5 * shape.hinge_m < shape.strain_m < 2.0 * shape.hinge_m
        inside.append(within_confidence(shape.root_from_cell, truth, shape.covariance).mean())
        scale = np.repeat([1.0, 0.5], 3)
        without.append(within_confidence(shape.root_from_cell, truth, shape.covariance * scale[:, None] * scale).mean())
    assert np.mean(inside) > 0.85
    assert np.mean(without) < np.mean(inside), "positions half as uncertain would be an overstatement"


def test_independent_gaps_are_not_taken_for_strain(seed: int) -> None:
    ratios = []
    for number in range(3):
        random = np.random.default_rng(seed + number)
        patch = forearm_patch(random, hinge_rms_m=5e-4)
        felt = gravity_readings(patch.patch_from_cell, random_directions(random, 8), random)
        shape = reconstruct(explore(patch.lists), GravitySamples.from_raw(felt))
        ratios.append((shape.strain_m / shape.hinge_m) ** 2)
    assert np.median(ratios) < 0.5


def test_hinges_that_close_leave_nothing_to_strain(seed: int) -> None:
    random = np.random.default_rng(seed)
    patch = forearm_patch(random)
    felt = gravity_readings(patch.patch_from_cell, random_directions(random, 8), random)
    assert reconstruct(explore(patch.lists), GravitySamples.from_raw(felt)).strain_m < 2e-5
