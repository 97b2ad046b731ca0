# SPDX-License-Identifier: Apache-2.0
import numpy as np
import pytest

from robotskin.selfconfig.common.gravity import GRAVITY_MPS2
from robotskin.selfconfig.common.prior_knowledge import PriorKnowledge
from robotskin.selfconfig.readings.gravity_samples import GravitySamples
from robotskin.selfconfig.reconstruction.accuracy import mean_errors, pose_errors, within_confidence
from robotskin.selfconfig.reconstruction.gravity_adjustment import GravityAdjustment, PatchState, Step
from robotskin.selfconfig.reconstruction.hinge import gap_vectors
from robotskin.selfconfig.reconstruction.observability import UnobservableRotationError
from robotskin.selfconfig.reconstruction.procrustes import reconstruct_by_chain
from robotskin.selfconfig.reconstruction.reconstruction import reconstruct
from robotskin.selfconfig.simulated.limb import (
    AccelerometerImperfections,
    SimulatedPatch,
    forearm_patch,
    gravity_readings,
    random_directions,
)
from robotskin.selfconfig.topology.neighbours import NeighbourLists
from robotskin.selfconfig.topology.topology import Topology, explore

IDEAL = AccelerometerImperfections.none()
USUAL = AccelerometerImperfections.ideal()


@pytest.fixture
def random(seed: int) -> np.random.Generator:
    return np.random.default_rng(seed)


def small_patch(random: np.random.Generator, hinge_rms_m: float = 0.0) -> tuple[SimulatedPatch, Topology, np.ndarray]:
    patch = forearm_patch(random, columns=4, rows=4, hinge_rms_m=hinge_rms_m)
    topology = explore(patch.lists)
    return patch, topology, patch.root_from_cell(int(topology.root[0]))


def test_flawless_readings_give_the_true_shape(random: np.random.Generator) -> None:
    patch, topology, truth = small_patch(random)
    readings = gravity_readings(patch.patch_from_cell, random_directions(random, 8), random, IDEAL)
    result = reconstruct(topology, GravitySamples.from_raw(readings))
    rotation, position = mean_errors(result.root_from_cell, truth)
    assert rotation < 0.03, "what is known of accelerometers and of hinges pulls a little"
    assert position < 0.005
    chained = mean_errors(reconstruct_by_chain(topology, GravitySamples.from_raw(readings)), truth)
    assert max(chained) < 1e-4, "without faults the paper's method is exact too"


def test_faulty_accelerometers_cost_the_chain_more_than_the_adjustment(random: np.random.Generator) -> None:
    patch, topology, truth = small_patch(random)
    samples = GravitySamples.from_raw(
        gravity_readings(patch.patch_from_cell, random_directions(random, 8), random, USUAL)
    )
    ours = mean_errors(reconstruct(topology, samples).root_from_cell, truth)
    paper = mean_errors(reconstruct_by_chain(topology, samples), truth)
    centred = mean_errors(reconstruct_by_chain(topology, samples, centred=True), truth)
    assert ours[0] < 0.6
    assert ours[1] < 0.4
    assert paper[0] > 3 * ours[0]
    assert centred[0] > ours[0]


def test_derivatives_are_those_of_the_cost(random: np.random.Generator) -> None:
    patch, topology, truth = small_patch(random, 1e-3)
    up = random_directions(random, 4)
    samples = GravitySamples.from_raw(gravity_readings(patch.patch_from_cell, up, random))
    root = int(topology.root[0])
    problem = GravityAdjustment(topology.edges, root, samples, PriorKnowledge(bend_rad=1e3), 3e-4)
    count = len(truth)
    state = PatchState(
        truth,
        random.normal(0, 0.3, (count, 3)),
        1 + random.normal(0, 0.02, (count, 3)),
        up @ truth[root, :3, :3],
        random.normal(0, 0.01, (count, 3)),
        random.normal(0, 0.005, (count, 3)),
    )
    weights = problem.weights(state)
    normal = problem.linearise(state, weights)
    base = problem.cost(state, weights)
    for damping in (1e3, 1e5):
        # A short step downhill changes the cost by the gradient the normal equations were built from.
        step = normal.step(damping)
        parts = (step.rotation, step.position, step.calibration, step.up)
        pose = np.concatenate([step.rotation, step.position], axis=1)[problem.column >= 0].ravel()
        tilt = np.einsum("kjt,kj->kt", normal.tangent, step.up).ravel()
        full = np.concatenate([pose, tilt])
        reduced_gradient = float(normal.right @ full)
        calibration_gradient = float(
            sum(
                normal.inner_right[cell] @ (step.calibration[cell] + normal.inner_inverse[cell] @ normal.coupling[cell]
                                            @ np.concatenate([step.rotation[cell], tilt]))
                for cell in range(count)
            )
        )  # fmt: skip
        either = [
            problem.cost(problem.moved(state, Step(*(s * part for part in parts), 0.0)), weights) for s in (1e-3, -1e-3)
        ]
        slope = (either[0] - either[1]) / 2e-3
        assert slope == pytest.approx(reduced_gradient + calibration_gradient, rel=1e-4)
        assert slope < 0 < base


@pytest.mark.parametrize("hinge_rms_m", [0.0, 5e-4])
def test_the_stated_covariance_is_honest(random: np.random.Generator, hinge_rms_m: float) -> None:
    inside = []
    for _ in range(6):
        patch, topology, truth = small_patch(random, hinge_rms_m)
        samples = GravitySamples.from_raw(gravity_readings(patch.patch_from_cell, random_directions(random, 8), random))
        result = reconstruct(topology, samples)
        others = np.arange(len(truth)) != result.root
        inside += within_confidence(result.root_from_cell, truth, result.covariance)[others].tolist()
    assert np.mean(inside) > 0.85
    # It is not honest either to state far more than the error.
    typical = np.sqrt(np.trace(result.covariance[others][:, :3, :3], axis1=1, axis2=2).mean())
    assert typical < 5 * np.linalg.norm(pose_errors(result.root_from_cell, truth)[0], axis=1).mean() + 1e-3


def test_the_hinge_tolerance_is_estimated(random: np.random.Generator) -> None:
    patch = forearm_patch(random, columns=6, rows=5, hinge_rms_m=6e-4)
    topology = explore(patch.lists)
    samples = GravitySamples.from_raw(gravity_readings(patch.patch_from_cell, random_directions(random, 8), random))
    result = reconstruct(topology, samples)
    assert 2e-4 < result.hinge_m < 6e-4, "6e-4 rms in three axes is 3.5e-4 along one"
    assert np.linalg.norm(gap_vectors(result.root_from_cell, result.edges) - result.gap) < 1e-12


def test_bumps_and_dead_cells_are_survived_and_named(random: np.random.Generator) -> None:
    patch, topology, truth = small_patch(random)
    readings = gravity_readings(patch.patch_from_cell, random_directions(random, 8), random, USUAL)
    others = np.setdiff1d(np.arange(len(patch)), topology.root)
    dead, bumped = random.choice(others, 2, replace=False)
    readings[dead] = np.nan
    readings[bumped, 3] += 0.5 * GRAVITY_MPS2
    readings[others[0] if others[0] not in (dead, bumped) else others[-1], 5, :4] = np.nan
    result = reconstruct(topology, GravitySamples.from_raw(readings))
    live = ~result.silent
    assert np.flatnonzero(result.silent).tolist() == [dead]
    assert mean_errors(result.root_from_cell[live], truth[live])[0] < 0.7
    assert result.reading_weight[bumped, 3] < 0.1
    assert (result.reading_weight[live] > 0.5).mean() > 0.95
    deviation = np.sqrt(np.trace(result.covariance[:, :3, :3], axis1=1, axis2=2))
    assert deviation[dead] > deviation[live].max(), "a cell placed by its hinges alone says so"


@pytest.mark.parametrize(
    ("up", "why"),
    [
        ([[0.0, 0.0, 1.0]], "only one pose"),
        ([[0.0, 0.6, 0.8], [0.0, 0.6, 0.8], [0.0, 0.6, 0.8]], "did not move"),
        ([[0.0, 0.6, 0.8], [0.0, -0.6, -0.8]], "nearly parallel"),
    ],
)
def test_open_rotations_are_errors_that_name_them(random: np.random.Generator, up: list, why: str) -> None:
    patch, topology, _ = small_patch(random)
    readings = gravity_readings(patch.patch_from_cell, np.array(up), random)
    with pytest.raises(UnobservableRotationError, match=why) as raised:
        reconstruct(topology, GravitySamples.from_raw(readings))
    axis = patch.patch_from_cell[raised.value.cell, :3, :3] @ raised.value.axis_in_cell
    assert abs(axis @ np.array(up)[0]) > 0.98, "what is open is the rotation about gravity"
    assert raised.value.uncertainty_rad > 0.2


def test_two_poses_are_enough(random: np.random.Generator) -> None:
    patch, topology, truth = small_patch(random)
    readings = gravity_readings(patch.patch_from_cell, np.array([[0.0, 0.0, 1.0], [1.0, 0.0, 0.0]]), random)
    result = reconstruct(topology, GravitySamples.from_raw(readings))
    assert mean_errors(result.root_from_cell, truth)[0] < 4.0


def test_a_lone_cell_is_its_own_frame(random: np.random.Generator) -> None:
    topology = explore(NeighbourLists([7], [[0, 0, 0, 0]]))
    readings = gravity_readings(np.eye(4)[None], random_directions(random, 6), random)
    result = reconstruct(topology, GravitySamples.from_raw(readings))
    assert np.array_equal(result.root_from_cell, np.eye(4)[None])


def test_samples_average_and_know_their_noise(random: np.random.Generator) -> None:
    raw = random.normal(0, 0.1, (3, 40, 16, 3))
    raw[1, 2] = np.nan
    raw[2, 3, 5] = np.nan
    samples = GravitySamples.from_raw(raw)
    assert np.allclose(samples.deviation, 0.1 / 4, rtol=0.15)
    assert samples.present().sum() == 3 * 40 - 1
    assert np.allclose(samples.mean[2, 3], np.nanmean(raw[2, 3], axis=0))
    with pytest.raises(ValueError, match="must be"):
        GravitySamples.from_raw(raw[0])


def test_inputs_are_not_changed(random: np.random.Generator) -> None:
    patch, topology, _ = small_patch(random)
    readings = gravity_readings(patch.patch_from_cell, random_directions(random, 8), random)
    samples = GravitySamples.from_raw(readings)
    before = samples.mean.copy(), samples.deviation.copy(), topology.edges.copy()
    reconstruct(topology, samples)
    assert np.array_equal(before[0], samples.mean)
    assert np.array_equal(before[1], samples.deviation)
    assert np.array_equal(before[2], topology.edges)
