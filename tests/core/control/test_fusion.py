# SPDX-License-Identifier: Apache-2.0
"""Fusion: lower levels leave higher ones alone, limits hold, and the fast way equals the plain one."""

import numpy as np
import pytest
from random_skin import at_random_posture, random_posture

from robotskin import robots
from robotskin.model import RobotDynamics, RobotModel
from robotskin.skin import SkinState
from robotskin.tasks import (
    QUADRATIC_TOLERANCE,
    ControlError,
    Damping,
    Fusion,
    GravityTask,
    Inverse,
    JointGains,
    JointTask,
    LimitForm,
    NullSpaceFusion,
    QuadraticFusion,
    QuadraticLimits,
    StackEntry,
    TaskStack,
)

Levels = list[tuple[np.ndarray, np.ndarray]]


def random_levels(robot: RobotModel, dynamics: RobotDynamics, rng: np.random.Generator) -> Levels:
    """Frames of some links, then every joint; each level with torques from within its rows."""
    n = robot.joint_count
    moving = np.flatnonzero(robot.link_joints >= 3)
    levels = []
    for link, size in zip(rng.choice(moving, 2, replace=False), (3, 2), strict=True):
        rows = np.ascontiguousarray(dynamics.link_jacobian(int(link))[rng.permutation(6)[:size]])
        levels.append((rows.T @ rng.normal(size=size), rows))
    return [*levels, (rng.normal(size=n), np.eye(n))]


def plain(mass: np.ndarray, levels: Levels, inverse: Inverse) -> np.ndarray:
    """Eq. 19 and 20, with matrices written out."""
    n = len(mass)
    weight = np.linalg.inv(mass) if inverse is Inverse.dynamically_consistent else np.eye(n)
    projector, fused = np.eye(n), np.zeros(n)
    for torque, rows in levels:
        fused += projector @ torque
        augmented = rows @ projector.T
        square, direction = np.linalg.eigh(augmented @ weight @ augmented.T)
        assert not ((square > 1e-12) & (square < 1e-7)).any(), "too near a singularity to compare"
        inverse_square = np.divide(1, square, where=square > 1e-7, out=np.zeros_like(square))
        pseudo = weight @ augmented.T @ (direction * inverse_square @ direction.T)
        projector = projector @ (np.eye(n) - augmented.T @ pseudo.T)
    return fused


@pytest.mark.parametrize("inverse", list(Inverse))
def test_recursion_equals_the_plain_equations(robot, rng, inverse) -> None:
    fusion = NullSpaceFusion(robot.joint_count, 100, inverse, Damping(1e-4, 1e-4))
    compared = 0
    for _ in range(30):
        dynamics = at_random_posture(robot, rng)
        levels = random_levels(robot, dynamics, rng)
        try:
            expected = plain(dynamics.mass_matrix, levels, inverse)
        except AssertionError:
            continue
        compared += 1
        fused = fusion.fuse(dynamics.mass_matrix, levels)
        np.testing.assert_allclose(fused, expected, atol=1e-6 * np.abs(expected).max())
    assert compared > 10


def test_lower_levels_do_not_accelerate_higher_ones(robot, rng) -> None:
    fusion = NullSpaceFusion(robot.joint_count, 100, Inverse.dynamically_consistent, Damping(1e-3, 1e-3))
    for _ in range(50):
        dynamics = at_random_posture(robot, rng)
        levels = random_levels(robot, dynamics, rng)
        whole = fusion.fuse(dynamics.mass_matrix, levels)
        without = fusion.fuse(dynamics.mass_matrix, levels[:-1])
        caused = levels[0][1] @ dynamics.solve_mass(whole - without)
        feedforward = levels[0][1] @ dynamics.solve_mass(levels[-1][0])
        assert np.linalg.norm(caused) <= 1e-6 * np.linalg.norm(feedforward)


def test_moore_penrose_leaves_higher_levels_at_rest_only(robot, rng) -> None:
    fusion = NullSpaceFusion(robot.joint_count, 100, Inverse.moore_penrose, Damping(1e-3, 1e-3))
    leaked = 0.0
    for _ in range(20):
        dynamics = at_random_posture(robot, rng)
        levels = random_levels(robot, dynamics, rng)
        lower = fusion.fuse(dynamics.mass_matrix, levels) - fusion.fuse(dynamics.mass_matrix, levels[:-1])
        rows = levels[0][1]
        assert np.linalg.norm(rows @ lower) <= 1e-9 * np.linalg.norm(rows @ levels[-1][0])
        leaked = max(leaked, np.linalg.norm(rows @ dynamics.solve_mass(lower)))
    assert leaked > 1e-3, "of accelerations it makes no promise"


def test_near_a_singularity_the_leak_keeps_its_bound(rng) -> None:
    n, damping = 6, Damping(0.1, 0.1)
    fusion = NullSpaceFusion(n, 20, Inverse.moore_penrose, damping)
    for singular in np.geomspace(1e-6, 0.0999, 40):
        left, right = np.linalg.qr(rng.normal(size=(3, 3)))[0], np.linalg.qr(rng.normal(size=(n, n)))[0]
        rows = np.ascontiguousarray(left @ np.diag([1.0, 0.5, singular]) @ right[:3])
        lower = rng.normal(size=n)
        passed = fusion.fuse(np.eye(n), [(np.zeros(n), rows), (lower, np.eye(n))])
        square = damping.damping**2 * (1 - (singular / damping.threshold) ** 2)
        share = np.array([0.0, 0.0, square / (singular**2 + square)])
        np.testing.assert_allclose(right[:3] @ passed, share * (right[:3] @ lower), atol=1e-7)


def test_the_projection_has_no_step_where_a_row_fades(robot, rng) -> None:
    fusion = NullSpaceFusion(robot.joint_count, 100, Inverse.dynamically_consistent)
    dynamics = at_random_posture(robot, rng)
    (torque, rows), _, lowest = random_levels(robot, dynamics, rng)
    fused = [
        fusion.fuse(dynamics.mass_matrix, [(share * torque, share * rows), lowest]) for share in np.linspace(0, 1, 4000)
    ]
    whole = np.abs(fused[-1] - fused[0]).max()
    assert np.abs(np.diff(fused, axis=0)).max() < 0.12 * whole


def test_many_rows_go_block_by_block(rng) -> None:
    robot = robots.load("talos_reduced").core
    dynamics = at_random_posture(robot, rng)
    n = robot.joint_count
    rows = np.ascontiguousarray(np.eye(n)[: n - 4])
    lower = rng.normal(size=n)
    fusion = NullSpaceFusion(n, 100, Inverse.dynamically_consistent)
    fused = fusion.fuse(dynamics.mass_matrix, [(np.zeros(n), rows), (lower, np.eye(n))])
    np.testing.assert_allclose(dynamics.solve_mass(fused)[: n - 4], 0, atol=1e-8)
    assert np.abs(dynamics.solve_mass(fused)[n - 4 :]).max() > 1e-3


def test_claimed_rows_beyond_the_capacity_are_refused(robot) -> None:
    n = robot.joint_count
    fusion = NullSpaceFusion(n, 2, Inverse.moore_penrose)
    with pytest.raises(ValueError, match="levels"):
        fusion.fuse(np.eye(n), [(np.zeros(n), np.eye(n)), (np.zeros(n), np.eye(n))])


# ---- Quadratic programmes ----


def wide(robot: RobotModel) -> QuadraticLimits:
    limits = QuadraticLimits.of(robot)
    n = robot.joint_count
    limits.lower, limits.upper = [-np.inf] * n, [np.inf] * n
    limits.velocity, limits.torque = [np.inf] * n, [np.inf] * n
    return limits


def quadratic(robot: RobotModel, limits: QuadraticLimits) -> QuadraticFusion:
    return QuadraticFusion(robot.joint_count, 100, 3, limits)


@pytest.mark.parametrize(
    ("name", "value"), [("margin_rad", np.nan), ("margin_rad", -0.1), ("horizon_s", 0.0), ("horizon_s", np.nan)]
)
def test_limits_that_would_limit_nothing_are_refused(robot, name: str, value: float) -> None:
    limits = wide(robot)
    setattr(limits, name, value)
    with pytest.raises(ControlError, match="margin_rad" if name == "margin_rad" else "horizon"):
        quadratic(robot, limits)


def test_within_the_limits_each_level_gets_what_it_asks_for(robot, rng) -> None:
    fusion = quadratic(robot, wide(robot))
    compared = 0
    for _ in range(40):
        q, v = random_posture(robot, rng)
        dynamics = RobotDynamics(robot)
        dynamics.update(q, v)
        levels = random_levels(robot, dynamics, rng)[:2]
        gravity = dynamics.gravity_torque
        fused = fusion.fuse(dynamics, q, v, gravity, levels)
        assert fusion.constrained == 0
        if np.linalg.svd(np.vstack([rows for _, rows in levels]))[1].min() < 5e-2:
            continue  # the levels want different things of one motion
        compared += 1
        for torque, rows in levels:
            asked = rows @ dynamics.solve_mass(torque)
            np.testing.assert_allclose(rows @ dynamics.solve_mass(fused - gravity), asked, atol=1e-3)
    assert compared > 5


def test_programmes_keep_the_limits_and_the_order(robot, rng) -> None:
    """Every joint within its acceleration and torque bounds; what lower levels ask for moves no higher one."""
    met = 0
    limits = QuadraticLimits.of(robot)
    n = robot.joint_count
    limits.torque = (0.5 * np.array(limits.torque)).tolist()
    limits.steps = 1000  # no state is like the one before
    fusion = quadratic(robot, limits)
    for _ in range(30):
        q = random_posture(robot, rng)[0]
        v = rng.uniform(-0.2, 0.2, n)
        dynamics = RobotDynamics(robot)
        dynamics.update(q, v)
        levels = [(300 * torque, rows) for torque, rows in random_levels(robot, dynamics, rng)]
        gravity = np.clip(dynamics.gravity_torque, -0.9 * np.array(limits.torque), 0.9 * np.array(limits.torque))
        whole = fusion.fuse(dynamics, q, v, gravity, levels)
        met += fusion.constrained > 0
        assert not fusion.report.fallback
        torque = np.array(limits.torque)
        assert (np.abs(whole) <= torque + 1e-3).all()
        acceleration = dynamics.forward_dynamics(whole)
        up = np.maximum(np.array(limits.upper) - limits.margin_rad - q, 0)
        fastest = np.minimum(np.sqrt(2 * np.array(limits.braking) * up), limits.velocity)
        free = np.abs(whole) < torque - 1e-2  # where the motor is too weak to brake, it does what it can
        if free.all():
            assert (acceleration <= (fastest - v) / limits.horizon_s + 1e-2).all()
        first = fusion.fuse(dynamics, q, v, gravity, levels[:1])
        caused = levels[0][1] @ dynamics.solve_mass(whole - first)
        feedforward = levels[0][1] @ dynamics.solve_mass(levels[1][0] + levels[2][0])
        assert np.linalg.norm(caused) <= 10 * QUADRATIC_TOLERANCE * np.linalg.norm(feedforward)
    assert met > 20, "the test met no limit"


def test_where_steps_end_and_come_back_the_torque_of_a_frozen_state_stays(robot, rng) -> None:
    """Within the limits all along: no step where the fall-back begins and ends, and only a slow one between."""
    n = robot.joint_count
    limits = QuadraticLimits.of(robot)
    limits.torque = (0.5 * np.array(limits.torque)).tolist()
    fell = 0
    for _ in range(15):
        q, v = random_posture(robot, rng)[0], np.zeros(n)
        dynamics = RobotDynamics(robot)
        dynamics.update(q, v)
        levels = [(300 * torque, rows) for torque, rows in random_levels(robot, dynamics, rng)]
        gravity = np.clip(dynamics.gravity_torque, -0.9 * np.array(limits.torque), 0.9 * np.array(limits.torque))
        fusion = quadratic(robot, limits)
        torques = []
        for steps in (1000, 1000, 3, 3, 3, 1000, 1000):
            fusion.set_steps(steps)
            torques.append(fusion.fuse(dynamics, q, v, gravity, levels))
            assert fusion.report.steps <= max(steps, fusion.report.room_steps)
            assert (np.abs(torques[-1]) <= np.array(limits.torque) + 1e-4).all()
            fell += fusion.report.fallback
            assert not fusion.report.fade_limited
        steps_nm = np.abs(np.diff(torques, axis=0)).max(axis=1)
        assert steps_nm[1] <= 1e-3, "where the fall-back begins"
        assert steps_nm[4] <= 1e-3, "where it ends"
        assert steps_nm[2:4].max() <= 2 * 0.001 / limits.fade_s * 2 * np.max(limits.torque)
    assert fell > 20


def test_a_motor_too_weak_to_brake_does_all_it_can(rng) -> None:
    """No torque keeps all limits: those of torque hold, and hardly any other joint misses its acceleration."""
    robot = robots.load("ur5").core
    limits = QuadraticLimits.of(robot)
    limits.torque = [2.0, *limits.torque[1:]]
    limits.upper = [0.1, *limits.upper[1:]]
    q, v = np.array([0.0, -1.2, 1.4, -1.0, -1.5, 0.0]), np.array([2.5, 0, 0, 0, 0, 0])
    dynamics = RobotDynamics(robot)
    dynamics.update(q, v)
    fusion = quadratic(robot, limits)
    torque = fusion.fuse(dynamics, q, v, dynamics.gravity_torque, [(50 * rng.normal(size=6), np.eye(6))])
    assert fusion.report.widened
    assert torque[0] == pytest.approx(-2.0, abs=1e-3)
    assert (np.abs(torque) <= np.array(limits.torque) + 1e-4).all()
    acceleration = dynamics.forward_dynamics(torque)
    assert (np.abs(acceleration[1:]) <= np.array(limits.velocity[1:]) / limits.horizon_s * 1.05).all()


def test_a_programme_is_the_best_of_what_is_allowed(rng) -> None:
    """On one level: nothing within the limits comes nearer to what is asked for."""
    robot = robots.load("ur5").core
    limits = QuadraticLimits.of(robot)
    fusion = quadratic(robot, limits)
    q, v = np.array([0.0, -1.2, 1.4, -1.0, -1.5, 0.0]), np.zeros(6)
    dynamics = RobotDynamics(robot)
    dynamics.update(q, v)
    asked = 400 * rng.normal(size=6)
    found = fusion.fuse(dynamics, q, v, np.zeros(6), [(asked, np.eye(6))])
    assert fusion.constrained == 1

    def miss(torque: np.ndarray) -> float:
        return float(np.sum(dynamics.solve_mass(torque - asked) ** 2))

    for _ in range(3000):
        other = found + rng.normal(size=6) * rng.choice([0.1, 1, 10])
        other = np.clip(other, -np.array(limits.torque), limits.torque)
        acceleration = dynamics.forward_dynamics(other)
        up = np.sqrt(2 * np.array(limits.braking) * np.maximum(np.array(limits.upper) - limits.margin_rad - q, 0))
        down = np.sqrt(2 * np.array(limits.braking) * np.maximum(q - np.array(limits.lower) - limits.margin_rad, 0))
        high = np.minimum(up, limits.velocity) / limits.horizon_s
        low = -np.minimum(down, limits.velocity) / limits.horizon_s
        if ((acceleration <= high) & (acceleration >= low)).all():
            assert miss(other) >= miss(found) * (1 - 1e-4)


def test_weighted_terms_share_one_programme(robot, rng) -> None:
    """Without limits it is the least squares of all rows; with them, no torque or acceleration leaves them."""
    n = robot.joint_count
    dynamics = at_random_posture(robot, rng)
    q, v, gravity = random_posture(robot, rng)[0], np.zeros(n), rng.normal(size=n)
    dynamics.update(q, v)
    rows = np.ascontiguousarray(dynamics.link_jacobian(robot.link_count - 1))
    terms = [(2.0, rows, 50 * rng.normal(size=6)), (0.3, np.eye(n), 20 * rng.normal(size=n))]
    free = QuadraticFusion(n, n + 6, 1, wide(robot)).fuse_weighted(dynamics, q, v, gravity, terms)
    stacked = np.vstack([np.sqrt(weight) * own for weight, own, _ in terms])
    wanted = np.concatenate([np.sqrt(weight) * own for weight, _, own in terms])
    expected = np.linalg.lstsq(stacked, wanted)[0]
    np.testing.assert_allclose(dynamics.forward_dynamics(free), expected, atol=2e-3 * np.abs(expected).max())

    limits = wide(robot)
    limits.torque = (0.5 * np.abs(free) + 1.2 * np.abs(gravity)).tolist()
    fusion = QuadraticFusion(n, n + 6, 1, limits)
    bound = fusion.fuse_weighted(dynamics, q, v, gravity, terms)
    assert (np.abs(bound) <= np.array(limits.torque) + 1e-5).all()
    again = fusion.fuse_weighted(dynamics, q, v, gravity, terms)
    np.testing.assert_allclose(again, bound, atol=1e-6 * np.abs(bound).max())
    with pytest.raises(ValueError, match="rows"):
        fusion.fuse_weighted(dynamics, q, v, gravity, [(1.0, rows, np.zeros(5))])


def test_the_papers_limits_forbid_holding_gravity_at_a_joint_limit() -> None:
    """Eq. 27 as printed lets a joint at its upper limit push only downwards, whatever hangs on it."""
    robot = robots.load("ur5").core
    q = np.array([0.0, -0.3, 0.5, 0.0, 0.0, 0.0])
    dynamics = RobotDynamics(robot)
    dynamics.update(q, np.zeros(6))
    gravity = dynamics.gravity_torque
    heavy = int(np.argmax(np.abs(gravity)))
    limits = QuadraticLimits.of(robot)
    at_limit = np.array(limits.upper if gravity[heavy] > 0 else limits.lower)
    at_limit[heavy] = q[heavy]
    sided = at_limit.tolist()
    if gravity[heavy] > 0:
        limits.upper = sided
    else:
        limits.lower = sided
    held = quadratic(robot, limits).fuse(dynamics, q, np.zeros(6), gravity, [(np.zeros(6), np.eye(6))])
    np.testing.assert_allclose(held, gravity, atol=1e-3)
    limits.form = LimitForm.paper
    printed = quadratic(robot, limits).fuse(dynamics, q, np.zeros(6), gravity, [(np.zeros(6), np.eye(6))])
    assert abs(printed[heavy]) < 1e-3 < abs(gravity[heavy])


# ---- Stacks ----


def test_weighted_sum_is_the_sum_of_weighted_torques(robot, rng) -> None:
    n = robot.joint_count
    q, v = random_posture(robot, rng)
    dynamics = RobotDynamics(robot)
    dynamics.update(q, v)
    task = JointTask(robot, JointGains([10.0] * n, [2.0] * n))
    stack = TaskStack(n, [StackEntry(task, 0, 0.5), StackEntry(GravityTask(n), -1)], Fusion.weighted_sum)
    none, share = SkinState(0), np.zeros(0, dtype=np.float32)
    stack.start(dynamics, q, v, none, share)
    fused = stack.compute(dynamics, q, v, none, share)
    np.testing.assert_allclose(fused, 0.5 * task.torque + dynamics.gravity_torque, atol=1e-9)


def test_a_stack_refuses_what_makes_none(robot) -> None:
    n = robot.joint_count
    task = JointTask(robot, JointGains([1.0] * n, [1.0] * n))
    with pytest.raises(ControlError, match="no task"):
        TaskStack(n, [], Fusion.weighted_sum)
    with pytest.raises(ControlError, match="twice"):
        TaskStack(n, [StackEntry(task), StackEntry(task)], Fusion.weighted_sum)
    with pytest.raises(ControlError, match="weight nan"):
        TaskStack(n, [StackEntry(task, 0, np.nan)], Fusion.weighted_sum)
    with pytest.raises(ControlError, match="level -2"):
        TaskStack(n, [StackEntry(task, -2)], Fusion.weighted_sum)
    with pytest.raises(ControlError, match="joints"):
        TaskStack(n, [StackEntry(GravityTask(n + 1))], Fusion.weighted_sum)
    with pytest.raises(ControlError, match="limits"):
        TaskStack(n, [StackEntry(task)], Fusion.quadratic)
    with pytest.raises(ControlError, match="damping"):
        TaskStack(n, [StackEntry(task)], Fusion.null_space, Damping(0.0, 1.0))
