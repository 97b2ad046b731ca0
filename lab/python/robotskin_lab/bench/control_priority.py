# SPDX-License-Identifier: Apache-2.0
"""`robotskin bench control`, priorities: how much lower levels move higher ones in random states of UR5 and Talos.

A leak is the acceleration of the higher level's motions that the lower one causes, over what it would cause without
projection. It is counted where the higher level's singular values are above the damping threshold; below it, the share
of each singular direction that passes is compared with its bound.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from robotskin import robots
from robotskin.model import RobotDynamics, RobotModel
from robotskin.tasks import (
    QUADRATIC_TOLERANCE,
    Damping,
    Inverse,
    NullSpaceFusion,
    QuadraticFusion,
    QuadraticLimits,
)

Array = NDArray[np.float64]
Level = tuple[Array, Array]


def priority_figures(seed: int, states: int) -> dict[str, float]:
    """Worst of `states` random states above the damping threshold, half of them the UR5's, half those of Talos, and of
    the states below it that are met on the way.
    """
    rng = np.random.default_rng(seed)
    damping = Damping()
    worst = dict.fromkeys(("consistent", "static", "singular", "excess", "quadratic", "constrained"), 0.0)
    counted = {"regular": 0, "singular": 0}
    for name in ("ur5", "talos"):
        robot = robots.load(name).core
        n = robot.joint_count
        dynamics = RobotDynamics(robot)
        consistent = NullSpaceFusion(n, 3 * n, Inverse.dynamically_consistent, damping)
        static = NullSpaceFusion(n, 3 * n, Inverse.moore_penrose, damping)
        quadratic = QuadraticFusion(n, 3 * n, 2, QuadraticLimits.of(robot))
        links = np.flatnonzero(robot.link_joints >= 4)
        wanted = counted["regular"] + states // 2
        index = 0
        while counted["regular"] < wanted:
            index += 1
            position, velocity = _random_state(robot, rng)
            dynamics.update(position, velocity)
            rows = np.ascontiguousarray(dynamics.link_jacobian(int(rng.choice(links)))[: rng.integers(2, 6)])
            high, low = (rows.T @ rng.normal(size=len(rows)), rows), (rng.normal(size=n), np.eye(n))
            mass = dynamics.mass_matrix
            weighted = np.linalg.solve(np.linalg.cholesky(mass), rows.T).T
            if _regular(weighted, damping):
                counted["regular"] += 1
                caused = rows @ dynamics.solve_mass(_of_lower(consistent, mass, high, low))
                worst["consistent"] = max(worst["consistent"], _share(caused, rows @ dynamics.solve_mass(low[0])))
            else:
                counted["singular"] += 1
                passed, bound = _singular(consistent, mass, high, low, weighted, damping)
                worst["singular"] = max(worst["singular"], float(passed.max()))
                worst["excess"] = max(worst["excess"], float((passed - bound).max()))
            if _regular(rows, damping):
                left = rows @ _of_lower(static, mass, high, low)
                worst["static"] = max(worst["static"], _share(left, rows @ low[0]))
            if index % 10 == 0:
                gravity = dynamics.gravity_torque
                pushed = (1000 * high[0], rows), (1000 * low[0], low[1])
                both = quadratic.fuse(dynamics, position, velocity, gravity, list(pushed))
                worst["constrained"] += quadratic.constrained > 0
                first = quadratic.fuse(dynamics, position, velocity, gravity, [pushed[0]])
                caused = rows @ dynamics.solve_mass(both - first)
                if _regular(weighted, damping):
                    share = _share(caused, rows @ dynamics.solve_mass(pushed[1][0]))
                    worst["quadratic"] = max(worst["quadratic"], share)
    return {
        "priority_leak": worst["consistent"],
        "priority_states": float(counted["regular"]),
        "priority_leak_singular": worst["singular"],
        "priority_leak_singular_over_bound": worst["excess"],
        "priority_states_singular": float(counted["singular"]),
        "static_leak": worst["static"],
        "hqp_leak": worst["quadratic"],
        "hqp_leak_over_tolerance": worst["quadratic"] / QUADRATIC_TOLERANCE,
        "hqp_limited_programmes": worst["constrained"],
    }


def _random_state(robot: RobotModel, rng: np.random.Generator) -> tuple[Array, Array]:
    position = rng.uniform(np.maximum(robot.lower, -np.pi), np.minimum(robot.upper, np.pi))
    return position, rng.uniform(-0.2, 0.2, robot.joint_count)


def _of_lower(fusion: NullSpaceFusion, mass: Array, high: Level, low: Level) -> Array:
    return fusion.fuse(mass, [high, low]) - fusion.fuse(mass, [high])


def _share(caused: Array, feedforward: Array) -> float:
    return float(np.linalg.norm(caused) / np.linalg.norm(feedforward))


def _regular(rows: Array, damping: Damping) -> bool:
    return float(np.linalg.svd(rows, compute_uv=False).min()) >= damping.threshold


def _singular(
    fusion: NullSpaceFusion, mass: Array, high: Level, low: Level, weighted: Array, damping: Damping
) -> tuple[Array, Array]:
    """Share that passes in each singular direction of the weighted rows, and its bound d^2 / (s^2 + d^2)."""
    factor = np.linalg.cholesky(mass)
    _, singular, direction = np.linalg.svd(weighted, full_matrices=False)
    passed = direction @ np.linalg.solve(factor, _of_lower(fusion, mass, high, low))
    asked = direction @ np.linalg.solve(factor, low[0])
    square = damping.damping**2 * np.clip(1 - (singular / damping.threshold) ** 2, 0, None)
    with np.errstate(invalid="ignore"):
        bound = np.where(singular > 1e-9, square / (singular**2 + square), 1.0)
    return np.abs(passed / asked), bound
