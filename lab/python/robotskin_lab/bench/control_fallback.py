# SPDX-License-Identifier: Apache-2.0
"""`robotskin bench control`, fall-back: what a command keeps where the solver's steps end before its work does.

States of Talos are drawn beneath half of its torque limits, with levels that ask for far more than these allow. Each
is frozen. The steps of a tick are cut to a drawn number, stay cut for a while, and come back.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

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

    `fallback_limit_violations`: cut ticks whose torque or acceleration leaves its bounds; only where no torque keeps
    all may an acceleration. `fallback_states_widened`: states in which bounds of acceleration gave way to those of
    torque, with enough steps or few; `fallback_states_widened_needlessly`: those of them in which some torque would
    have kept all. `fallback_most_room_steps`: the most that one tick took to find a torque within all limits.
    `fallback_jump_nm`: the largest step of a joint's torque in the tick in which the cut begins or ends, where no limit
    forbids that the torque stays; `fallback_jumps_by_limits`: how many ticks had such a limit; `fallback_level_error`:
    the most that a cut tick changes of what the levels above the cut have, as a share of what the levels ask for.
    `fallback_uncut_ticks`: ticks that fell back although they had steps left, as rounding hid their answer.
    """
    robot, limits = half_as_strong()
    cut = uncut = violations = by_limits = widened = needless = room_steps = 0
    jump = error = 0.0
    for state in drawn(robot, limits, seed, states):
        fusion = QuadraticFusion(robot.joint_count, 100, len(state.levels), limits)
        before = exact = state.fuse(fusion)
        fell = gave_way = False
        strict = True  # some torque keeps all limits
        bounds = Bounds(state.dynamics, limits, state.position, state.velocity)
        for steps in (ENOUGH_STEPS, *[state.few_steps] * CUT_TICKS, ENOUGH_STEPS, ENOUGH_STEPS):
            fusion.set_steps(steps)
            torque = state.fuse(fusion)
            report = fusion.report
            if report.widened and not gave_way:
                gave_way, strict = True, bounds.leave_a_choice()
            room_steps = max(room_steps, report.room_steps)
            if report.fade_limited:
                by_limits += 1
            elif report.fallback != fell:
                jump = max(jump, float(np.abs(torque - before).max()))
            if report.fallback:
                cut += 1
                uncut += report.steps < steps
                violations += not bounds.keep(torque, strict=strict)
                for asked, rows in state.levels[: report.finished]:
                    changed = np.linalg.norm(rows @ state.dynamics.solve_mass(torque - exact))
                    wanted = max(float(np.linalg.norm(rows @ state.dynamics.solve_mass(asked))), 1e-9)
                    error = max(error, float(changed / wanted))
            before, fell = torque, report.fallback
        widened += gave_way
        needless += gave_way and strict
    return {
        "fallback_cut_ticks": float(cut),
        "fallback_uncut_ticks": float(uncut),
        "fallback_limit_violations": float(violations),
        "fallback_states_widened": float(widened),
        "fallback_states_widened_needlessly": float(needless),
        "fallback_most_room_steps": float(room_steps),
        "fallback_jump_nm": jump,
        "fallback_jumps_by_limits": float(by_limits),
        "fallback_level_error": error,
    }


def half_as_strong() -> tuple[RobotModel, QuadraticLimits]:
    """Talos, and its limits with half of its torque; a tick has enough steps until it is cut."""
    robot = robots.load("talos").core
    limits = QuadraticLimits.of(robot)
    limits.torque = (0.5 * np.array(limits.torque)).tolist()
    limits.steps = ENOUGH_STEPS
    return robot, limits


@dataclass(frozen=True)
class State:
    """A drawn state, what is asked of it, and to how many steps its ticks are cut."""

    dynamics: RobotDynamics
    position: Vector
    velocity: Vector
    gravity: Vector
    levels: Levels
    few_steps: int

    def fuse(self, fusion: QuadraticFusion) -> Vector:
        """The torque of one tick."""
        return fusion.fuse(self.dynamics, self.position, self.velocity, self.gravity, self.levels)


def drawn(robot: RobotModel, limits: QuadraticLimits, seed: int, count: int) -> Iterator[State]:
    """The first `count` states of a seed."""
    rng = np.random.default_rng(seed)
    bound = 0.9 * np.array(limits.torque)
    for _ in range(count):
        position, velocity = _state(robot, rng)
        dynamics = RobotDynamics(robot)
        dynamics.update(position, velocity)
        levels = _levels(robot, dynamics, rng)
        gravity = np.clip(dynamics.gravity_torque, -bound, bound)
        yield State(dynamics, position, velocity, gravity, levels, int(rng.integers(1, MOST_CUT_STEPS)))


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

    def keep(self, torque: Vector, *, strict: bool) -> bool:
        """Whether the torque is within all of them, or, if not `strict`, within those of torque."""
        if (np.abs(torque) > self._torque + self.miss_nm).any():
            return False
        acceleration = self._dynamics.forward_dynamics(torque)
        within = (acceleration <= self._high + self.miss) & (acceleration >= self._low - self.miss)
        return not strict or bool(within.all())

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
