# SPDX-License-Identifier: Apache-2.0
import numpy as np
import pinocchio
import pytest

from robotskin.robots import from_text, load
from robotskin.selfconfig.dynamics.consistent_bodies import (
    DynamicsError,
    fit_bodies,
    is_consistent,
    pseudo_inertia_basis,
)
from robotskin.selfconfig.dynamics.dynamics import identify_dynamics
from robotskin.selfconfig.dynamics.excitation import MotionBounds, exciting_trajectory, random_trajectory
from robotskin.selfconfig.dynamics.torque_regressor import base_columns, torque_regressor

UR5 = load("ur5")
BOUNDS = MotionBounds(np.full(6, -2.0), np.full(6, 2.0), np.full(6, 1.5), np.full(6, 6.0))


def torques(motion: tuple[np.ndarray, np.ndarray, np.ndarray], coulomb: np.ndarray) -> np.ndarray:
    data = UR5.model.createData()
    rigid = [pinocchio.rnea(UR5.model, data, *instant).copy() for instant in zip(*motion, strict=True)]
    return np.array(rigid) + coulomb * np.sign(motion[1])


def test_series_are_their_own_derivatives_within_bounds_and_at_rest_at_both_ends(seed: int) -> None:
    trajectory = random_trajectory(BOUNDS, np.random.default_rng(seed))
    time_s, step = np.linspace(0.0, 10.0, 501), 1e-5
    posture, velocity, acceleration = trajectory.at(time_s)
    later, sooner = trajectory.at(time_s + step), trajectory.at(time_s - step)
    assert np.allclose((later[0] - sooner[0]) / (2 * step), velocity, atol=1e-6)
    assert np.allclose((later[1] - sooner[1]) / (2 * step), acceleration, atol=1e-6)
    assert (np.abs(posture) <= 2.0).all()
    assert (np.abs(velocity) <= 1.5).all()
    assert (np.abs(acceleration) <= 6.0).all()
    for end in (0, -1):
        assert np.abs(velocity[end]).max() < 1e-9
        assert np.abs(acceleration[end]).max() < 1e-9


def test_exciting_motion_tells_more_than_random_ones_and_stays_free(seed: int) -> None:
    random = np.random.default_rng(seed)

    def badness(trajectory: object) -> float:
        regressor = torque_regressor(UR5.model, *trajectory.at(np.linspace(0, 10, 60, endpoint=False)))  # type: ignore[attr-defined]
        columns = regressor[:, base_columns(regressor)]
        return float(np.linalg.cond(columns / np.linalg.norm(columns, axis=0)))

    found = exciting_trajectory(UR5.model, BOUNDS, random, is_free=lambda q: q[1] < 1.0, candidates=20, improvements=20)
    assert found.at(np.linspace(0, 10, 200, endpoint=False))[0][:, 1].max() < 1.0
    assert badness(found) < np.median([badness(random_trajectory(BOUNDS, random)) for _ in range(15)])
    with pytest.raises(ValueError, match="none of 20 trajectories is free"):
        exciting_trajectory(UR5.model, BOUNDS, random, is_free=lambda _: False, candidates=20)


def test_the_regressor_times_the_parameters_is_the_torque(seed: int) -> None:
    motion = random_trajectory(BOUNDS, np.random.default_rng(seed)).at(np.linspace(0, 10, 20))
    parameters = np.concatenate([body.toDynamicParameters() for body in list(UR5.model.inertias)[1:]])
    regressor = torque_regressor(UR5.model, *motion)
    assert np.allclose((regressor @ parameters).reshape(-1, 6), torques(motion, np.zeros(6)), atol=1e-9)
    base = base_columns(regressor)
    assert np.linalg.matrix_rank(regressor[:, base]) == len(base) == np.linalg.matrix_rank(regressor)


def test_the_pseudo_inertia_is_pinocchios(seed: int) -> None:
    random = np.random.default_rng(seed)
    for _ in range(5):
        body = pinocchio.LogCholeskyParameters(random.standard_normal(10)).toInertia()
        ours = np.einsum("i,iab->ab", body.toDynamicParameters(), pseudo_inertia_basis())
        assert np.allclose(ours, body.toPseudoInertia().toMatrix())
        assert is_consistent(body.toDynamicParameters())
        assert not is_consistent(-body.toDynamicParameters())


def test_every_fitted_body_could_exist_even_where_the_best_fit_could_not(seed: int) -> None:
    random = np.random.default_rng(seed)
    # Torques of a body of negative mass: least squares alone would give it back.
    matrix = random.standard_normal((60, 11))
    wanted = np.concatenate([-pinocchio.Inertia.FromSphere(1.5, 0.2).toDynamicParameters(), [-1.0]])
    found = fit_bodies(matrix, matrix @ wanted, links=1)
    assert is_consistent(found[:10])
    assert found[10] > 0


@pytest.mark.parametrize("strength", [1e2, 1e4, 1e6])
def test_light_bodies_settle_however_weak_the_pull_beside_the_torques(strength: float, seed: int) -> None:
    random = np.random.default_rng(seed)
    links = 3
    columns = strength * 10.0 ** random.uniform(-3, 0, 10 * links + 2)
    matrix = random.standard_normal((200, len(columns))) * columns
    bodies = [
        pinocchio.Inertia.FromSphere(10.0 ** random.uniform(-2, 1), 0.05).toDynamicParameters() for _ in range(links)
    ]
    right = matrix @ np.concatenate([*bodies, [0.01, 3.0]]) + 5.0 * random.standard_normal(200)
    found = fit_bodies(matrix, right, links)
    assert all(is_consistent(body) for body in found[:-2].reshape(links, 10))


def test_bodies_settle_where_torques_tell_some_combinations_a_myriad_times_better_than_others(seed: int) -> None:
    random = np.random.default_rng(seed)
    links, told, size = 7, 64, 84
    strengths = np.concatenate([np.geomspace(1e4, 1.0, told), np.zeros(size - told)])
    left, right_turn = (np.linalg.qr(random.standard_normal((size, size)))[0] for _ in range(2))
    matrix = left * strengths @ right_turn
    bodies = [
        pinocchio.Inertia.FromEllipsoid(random.uniform(0.05, 5), *random.uniform(0.02, 0.3, 3)).toDynamicParameters()
        for _ in range(links)
    ]
    right = matrix @ np.concatenate([*bodies, np.full(size - 10 * links, 0.5)]) + random.standard_normal(size)
    found = fit_bodies(matrix, right, links)
    assert all(is_consistent(body) for body in found[: 10 * links].reshape(links, 10))


def test_identified_torques_hold_on_other_motions(seed: int) -> None:
    random = np.random.default_rng(seed)
    motion = exciting_trajectory(UR5.model, BOUNDS, random, candidates=10, improvements=10).at(np.arange(0, 10, 0.02))
    coulomb = 0.05 * np.abs(torques(motion, np.zeros(6))).max(axis=0)
    clean = torques(motion, coulomb)
    noisy = clean + 0.01 * np.abs(clean).max(axis=0) * random.standard_normal(clean.shape)
    noisy[17, 2] = np.nan
    kinematics = pinocchio.Model(UR5.model)
    for joint in range(1, 7):
        kinematics.inertias[joint] = pinocchio.Inertia.Zero()
    found = identify_dynamics(kinematics, *motion, noisy)
    assert found.base_count == 36
    assert all(is_consistent(body) for body in found.parameters.reshape(6, 10))
    other = random_trajectory(BOUNDS, random).at(np.arange(0, 10, 0.1))
    wanted = torques(other, coulomb)
    share = np.sqrt(((found.torque(*other) - wanted) ** 2).mean(axis=0) / (wanted**2).mean(axis=0))
    assert share.max() < 0.03
    assert np.allclose(found.coulomb, coulomb, rtol=0.15)


def test_the_urdf_with_identified_masses_is_that_model(seed: int, tmp_path: object) -> None:
    random = np.random.default_rng(seed)
    motion = random_trajectory(BOUNDS, random).at(np.arange(0, 10, 0.05))
    found = identify_dynamics(UR5.model, *motion, torques(motion, np.zeros(6)))
    robot = from_text(found.urdf(UR5.urdf), name="found", folder=tmp_path)  # type: ignore[arg-type]
    data, again = found.model.createData(), robot.model.createData()
    instant = [part[7] for part in motion]
    assert np.allclose(pinocchio.rnea(found.model, data, *instant), pinocchio.rnea(robot.model, again, *instant))


def test_too_few_torques_and_wrong_shapes_are_errors() -> None:
    few = np.zeros((5, 6))
    with pytest.raises(DynamicsError, match="5 readings of 6 joints: at least 36"):
        identify_dynamics(UR5.model, few, few, few, few)
    with pytest.raises(ValueError, match=r"torque: shape \(5, 5\): must be \(5, 6\)"):
        identify_dynamics(UR5.model, few, few, few, np.zeros((5, 5)))
