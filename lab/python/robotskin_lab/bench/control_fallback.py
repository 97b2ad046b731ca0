# SPDX-License-Identifier: Apache-2.0
"""`robotskin bench control`, fall-back: what a command keeps where the solver's steps end before its work does.

States of Talos are drawn beneath half of its torque limits, with levels that ask for far more than these allow. Each
is frozen. The steps of a tick are cut to a drawn number, stay cut for a while, and come back.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray
from scipy.optimize import linprog

from robotskin import robots
from robotskin.model import RobotDynamics, RobotModel
from robotskin.tasks import QUADRATIC_TOLERANCE, QuadraticFusion, QuadraticLimits

Vector = NDArray[np.float64]
Levels = list[tuple[Vector, Vector]]

ENOUGH_STEPS, MOST_CUT_STEPS, CUT_TICKS = 2000, 60, 20


def fallback_figures(seed: int, states: int) -> dict[str, float]:
    """Over `states` states.

    `fallback_limit_violations`: cut ticks whose torque or acceleration leaves its bounds. `fallback_states_widened`:
    states in which a motor is too weak to brake as wanted, so that bounds of acceleration gave way to those of torque;
    `fallback_states_widened_needlessly`: those of them in which some torque would have kept all. `fallback_jump_nm`:
    the largest step of a joint's torque in the tick in which the cut begins or ends, where no limit forbids that the
    torque stays; `fallback_jumps_by_limits`: how many ticks had such a limit; `fallback_level_error`: the most that a
    cut tick changes of what the levels above the cut have, as a share of what the levels ask for.
    """
    rng = np.random.default_rng(seed)
    robot = robots.load("talos").core
    limits = QuadraticLimits.of(robot)
    limits.torque = (0.5 * np.array(limits.torque)).tolist()
    cut = violations = by_limits = widened = needless = 0
    jump = error = 0.0
    for _ in range(states):
        position, velocity = _state(robot, rng)
        dynamics = RobotDynamics(robot)
        dynamics.update(position, velocity)
        levels = _levels(robot, dynamics, rng)
        bound = np.array(limits.torque)
        gravity = np.clip(dynamics.gravity_torque, -0.9 * bound, 0.9 * bound)
        fusion = QuadraticFusion(robot.joint_count, 100, len(levels), limits)
        few = int(rng.integers(1, MOST_CUT_STEPS))
        before = exact = fusion.fuse(dynamics, position, velocity, gravity, levels)
        fell = False
        bounds = Bounds(dynamics, limits, position, velocity)
        for steps in (ENOUGH_STEPS, *[few] * CUT_TICKS, ENOUGH_STEPS, ENOUGH_STEPS):
            fusion.set_steps(steps)
            torque = fusion.fuse(dynamics, position, velocity, gravity, levels)
            report = fusion.report
            if report.fade_limited:
                by_limits += 1
            elif report.fallback != fell:
                jump = max(jump, float(np.abs(torque - before).max()))
            if report.fallback:
                cut += 1
                violations += not bounds.keep(torque, widened=report.widened)
                for asked, rows in levels[: report.finished]:
                    changed = np.linalg.norm(rows @ dynamics.solve_mass(torque - exact))
                    wanted = max(float(np.linalg.norm(rows @ dynamics.solve_mass(asked))), 1e-9)
                    error = max(error, float(changed / wanted))
            before, fell = torque, report.fallback
        if report.widened:
            widened += 1
            needless += bounds.leave_a_choice()
    return {
        "fallback_cut_ticks": float(cut),
        "fallback_limit_violations": float(violations),
        "fallback_states_widened": float(widened),
        "fallback_states_widened_needlessly": float(needless),
        "fallback_jump_nm": jump,
        "fallback_jumps_by_limits": float(by_limits),
        "fallback_level_error": error,
    }


def _state(robot: RobotModel, rng: np.random.Generator) -> tuple[Vector, Vector]:
    lower, upper = np.maximum(robot.lower, -2), np.minimum(robot.upper, 2)
    return rng.uniform(lower + 0.05, upper - 0.05), rng.uniform(-0.2, 0.2, robot.joint_count)


def _levels(robot: RobotModel, dynamics: RobotDynamics, rng: np.random.Generator) -> Levels:
    """Frames of three links, then every joint, each with forces far beyond what the motors have."""
    moving = np.flatnonzero(robot.link_joints >= 3)
    levels = []
    for link, size in zip(rng.choice(moving, 3, replace=False), (6, 6, 3), strict=True):
        rows = np.ascontiguousarray(dynamics.link_jacobian(int(link))[rng.permutation(6)[:size]])
        levels.append((300 * rows.T @ rng.normal(size=size), rows))
    return [*levels, (300 * rng.normal(size=robot.joint_count), np.eye(robot.joint_count))]


class Bounds:
    """The accelerations and torques that one state allows."""

    miss = 1e-2  # rad/s^2, of bounds that are some 100 rad/s^2
    miss_nm = 100 * QUADRATIC_TOLERANCE

    def __init__(self, dynamics: RobotDynamics, limits: QuadraticLimits, position: Vector, velocity: Vector) -> None:
        braking, torque = np.array(limits.braking), np.array(limits.torque)
        room_up = np.maximum(np.array(limits.upper) - limits.margin_rad - position, 0)
        room_down = np.maximum(position - np.array(limits.lower) - limits.margin_rad, 0)
        self._high = (np.minimum(np.sqrt(2 * braking * room_up), limits.velocity) - velocity) / limits.horizon_s
        self._low = (-np.minimum(np.sqrt(2 * braking * room_down), limits.velocity) - velocity) / limits.horizon_s
        self._torque, self._dynamics = torque, dynamics

    def keep(self, torque: Vector, *, widened: bool) -> bool:
        """Whether the torque is within all of them, or within those of torque where the others gave way."""
        if widened:
            return bool((np.abs(torque) <= self._torque + self.miss_nm).all())
        acceleration = self._dynamics.forward_dynamics(torque)
        return bool(
            (np.abs(torque) <= self._torque + self.miss_nm).all()
            and (acceleration <= self._high + self.miss).all()
            and (acceleration >= self._low - self.miss).all()
        )

    def leave_a_choice(self) -> bool:
        """Whether any torque keeps all of them: a motor too weak to brake does not."""
        n = len(self._torque)
        at_rest = self._dynamics.forward_dynamics(np.zeros(n))
        inverse = np.column_stack([self._dynamics.solve_mass(column) for column in np.eye(n)])
        rows = np.vstack([inverse, -inverse])
        found = linprog(
            np.zeros(n),
            A_ub=rows,
            b_ub=np.concatenate([self._high - at_rest, at_rest - self._low]),
            bounds=np.column_stack([-self._torque, self._torque]),
        )
        return bool(found.success)
