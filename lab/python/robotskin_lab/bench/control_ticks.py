# SPDX-License-Identifier: Apache-2.0
"""`robotskin bench control`, times: whole ticks, state in and command out, and the skin task in them.

Times of ticks are the processor's own of their thread, which waiting for others does not stretch; those on the clock on
the wall have `_wall` in their names. A microsecond depends on the machine and on what else runs there, so each time
stands beside its ratio to one kernel of the same run, the update of Talos' dynamics by Pinocchio (`reference_kernel`).
A machine that others share changes its speed within a second. So the kernel is timed between laps of ticks: `_ratio` is
to its median in the whole run, `_lap_ratio` to what it takes around the lap of the tick.
The same ticks run twice, and of each the lesser processor time counts: their work is equal to the step, so what differs
is what the rest of the machine does to its caches.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np
from numpy.typing import NDArray

from robotskin import robots
from robotskin.control.self_collision import self_collision_task
from robotskin.cycle import SafetyState, TaskCycle
from robotskin.layout import finished
from robotskin.model import CommandMode, JointCommand, JointState, RobotModel
from robotskin.robots import Robot
from robotskin.robots.gains import GainSet
from robotskin.skin import Health, SkinModel, SkinState
from robotskin.tasks import (
    FEEDFORWARD,
    CartesianTask,
    Fusion,
    GravityTask,
    JointLimitTask,
    JointTask,
    QuadraticLimits,
    SkinGains,
    SkinReactionTask,
    StackEntry,
    TouchWrench,
)
from robotskin_lab._lab.baselines import time_dynamics_update, time_skin_task

Figures = dict[str, Any]
REFERENCE = "RobotDynamics.update of talos (Pinocchio: nonlinear effects, gravity, mass matrix, its factor)"
STATES = 64
WARM_UP = 200
LAP = 10 * STATES
REFERENCE_ROUNDS = 200
TOUCHED_SHARE = 0.1


def tick_figures(seed: int, ticks: int) -> Figures:
    """Times of the ticks of Talos and of the UR5."""
    figures: Figures = {}
    rng = np.random.default_rng(seed)
    talos, ur5 = Rig("talos", rng), Rig("ur5", rng)
    for key, fusion, squeeze in (
        ("nullspace", Fusion.null_space, 1.0),
        ("hqp", Fusion.quadratic, 1.0),
        ("hqp_limited", Fusion.quadratic, 0.25),
    ):
        hands = ("gripper_left_base_link", "gripper_right_base_link")
        figures |= talos.times(f"talos_tick_{key}", hands, fusion, ticks, squeeze)
    shares = [value for key, value in figures.items() if key.endswith("_fallback_ticks_share")]
    figures["fallback_ticks_share"] = max(shares)
    figures |= ur5.times("ur5_tick", ("ee_link",), Fusion.null_space, ticks, 1.0)
    return figures | {"reference_us": float(np.median(talos.reference.taken_us + ur5.reference.taken_us))}


def skin_figures(seed: int, rounds: int) -> Figures:
    """Times of the skin task with thresholds, activation and torques, at 1260 and at 100 000 cells."""
    rng = np.random.default_rng(seed)
    robot, skin = robots.load("talos").core, finished("talos").skin_model()
    small = _skin_times(robot, skin, rng, rounds)
    large = _skin_times(robot, _repeated(skin, 100_000), rng, max(rounds // 100, 40))
    a_cell = small["task"] / len(skin)
    return {
        "skin_task_1260_us": small["task"],
        "skin_product_1260_us": small["product"],
        "skin_product_single_1260_us": small["single"],
        "skin_task_ratio": small["task"] / small["product"],
        "skin_task_100000_us": large["task"],
        "skin_task_scaling": large["task"] / 100_000 / a_cell,
    }


def ratio_figures(seed: int, figures: Figures, rounds: int = 3000) -> Figures:
    """The reference kernel, its median microseconds, and each time of `figures` over it."""
    times = {key.removesuffix("_us"): value for key, value in figures.items() if key.endswith("_us")}
    reference = times.pop("reference", None)
    if not times:
        return {}
    if reference is None:
        reference = Reference(np.random.default_rng(seed)).median_us(rounds)
    ratios = {f"{key}_ratio": value / reference for key, value in times.items()}
    return {"reference_kernel": REFERENCE, "reference_us": reference} | ratios


class Reference:
    """The kernel that tells how fast the machine is at this moment."""

    def __init__(self, rng: np.random.Generator) -> None:
        self.robot = robots.load("talos").core
        self.posture = _posture(self.robot, rng)
        self.taken_us: list[float] = []

    def median_us(self, rounds: int = REFERENCE_ROUNDS) -> float:
        """Median microseconds of `rounds` updates, after some that are not timed."""
        time_dynamics_update(self.robot, self.posture, 20)
        self.taken_us.append(float(np.median(time_dynamics_update(self.robot, self.posture, rounds))) / 1e3)
        return self.taken_us[-1]


class Rig:
    """A robot in its finished skin, in states near its home posture, some cells touched."""

    def __init__(self, name: str, rng: np.random.Generator) -> None:
        self.robot: Robot = robots.load(name)
        self.core, self.skin = self.robot.core, finished(name).skin_model()
        self.gain_set = GainSet.load(name)
        self.gains = self.gain_set.cycle_gains(self.core, self.skin)
        self.states = self._path(rng)
        self.touch = _touched(len(self.skin), rng, TOUCHED_SHARE)
        self.reference = Reference(rng)

    def _path(self, rng: np.random.Generator) -> list[JointState]:
        """Joint states around a closed path, so that nothing jumps from one to the next."""
        home, n = self.gain_set.home, self.core.joint_count
        room = np.minimum(np.minimum(home - self.core.lower, self.core.upper - home) / 2, 0.2)
        turn = rng.uniform(0, 2 * np.pi, n)
        states = []
        for i in range(STATES):
            state = JointState(n)
            state.position = home + room * np.sin(2 * np.pi * i / STATES + turn)
            state.velocity = np.minimum(0.3, 0.3 * self.core.velocity_limit) * np.cos(2 * np.pi * i / STATES + turn)
            states.append(state)
        return states

    def five_levels(self, hands: tuple[str, ...]) -> list[StackEntry]:
        """Limits, self-collision, hands, skin, posture; gravity beside them."""
        touch = TouchWrench(self.core, self.skin, self.gain_set.skin_gains(self.core, self.skin))
        pose = self.gain_set.choose("reach_cartesian_compliant").cartesian
        return [
            StackEntry(GravityTask(self.core.joint_count), FEEDFORWARD),
            StackEntry(JointLimitTask(self.core), 0),
            StackEntry(self_collision_task(self.robot, self.gain_set.home), 1),
            *(StackEntry(CartesianTask(self.core, hand, pose, hand), 2) for hand in hands),
            StackEntry(SkinReactionTask(touch, self.gains.touch_bandwidth_hz), 3),
            StackEntry(JointTask(self.core, self.gain_set.joint, "posture"), 4),
        ]

    def times(self, key: str, hands: tuple[str, ...], fusion: Fusion, ticks: int, squeeze: float) -> Figures:
        """Median, 99 % and worst of ticks; `squeeze` is the share of the torque limits that the programmes get."""
        (first, counted), (again, counted_again) = (self._run(key, hands, fusion, ticks, squeeze) for _ in range(2))
        if counted != counted_again:
            raise RuntimeError(f"{key}: the same ticks took other steps when they ran again")
        lesser = lesser_of(first, again)
        return {**time_figures(key, lesser[:, :2]), **time_figures(key, lesser[:, 2:], "lap_ratio"), **counted}

    def _run(
        self, key: str, hands: tuple[str, ...], fusion: Fusion, ticks: int, squeeze: float
    ) -> tuple[NDArray[np.float64], Figures]:
        """Of each tick (ticks, 4) microseconds on the clock and of the processor, then both over the reference.

        Beside them what the programmes counted.
        """
        limits = QuadraticLimits.of(self.core)
        gravity = 1.2 * np.abs(_gravity(self.robot, self.gain_set.home))
        limits.torque = np.maximum(squeeze * np.array(limits.torque), gravity).tolist()
        guard = self.gain_set.guard_limits(self.core)
        entries = self.five_levels(hands)
        cycle = TaskCycle(self.core, self.skin, self.gains, guard, entries, fusion, quadratic=limits)
        cycle.request_mode(CommandMode.torque)
        cycle.request_run(True)
        command = JointCommand(CommandMode.torque, self.core.joint_count)
        run = 0

        def timed_us(steps: int) -> NDArray[np.float64]:
            nonlocal run
            start_ns = 10**9 + run * 1_000_000
            run += steps
            return cycle.time_steps(self.states, self.touch, start_ns, command, steps) / 1e3

        timed_us(WARM_UP)
        measured = timed_laps(timed_us, self.reference.median_us, ticks)
        if cycle.report.state != SafetyState.running:
            raise RuntimeError(f"{key}: the robot stopped while it was timed: {cycle.report.text}")
        if fusion is not Fusion.quadratic:
            return measured, {}
        counts = cycle.fusion_counts
        return measured, {
            f"{key}_fallback_ticks_share": counts.fallback_ticks / run,
            f"{key}_most_steps": float(counts.most_steps),
        }


def timed_laps(
    timed_us: Callable[[int], NDArray[np.float64]], reference_us: Callable[[], float], ticks: int
) -> NDArray[np.float64]:
    """`ticks` times (ticks, 2) of `timed_us`, and beside them (ticks, 4) their ratios to the reference of their lap.

    That is the mean of the reference before and after the lap.
    """
    laps, before_us = [], reference_us()
    for start in range(0, ticks, LAP):
        timed_us(STATES)  # The reference has taken the caches.
        lap_us = timed_us(min(LAP, ticks - start))
        after_us = reference_us()
        laps.append(np.column_stack([lap_us, lap_us / ((before_us + after_us) / 2)]))
        before_us = after_us
    return np.concatenate(laps)


def lesser_of(first: NDArray[np.float64], again: NDArray[np.float64]) -> NDArray[np.float64]:
    """Of two runs of the same ticks (ticks, 4) the lesser time of the processor, with the ratio that belongs to it.

    Times on the clock, and their ratios, are those of the first run.
    """
    lesser = first.copy()
    faster = again[:, 1] < first[:, 1]
    for column in (1, 3):
        lesser[faster, column] = again[faster, column]
    return lesser


def time_figures(key: str, times: NDArray[np.float64], unit: str = "us") -> Figures:
    """Median, 99 % and worst of times (ticks, 2): first those on the clock, `_wall`, then those of the processor."""
    return {
        f"{key}{of}_{name}_{unit}": float(value)
        for of, column in zip(("_wall", ""), times.T, strict=True)
        for name, value in (("median", np.median(column)), ("p99", np.percentile(column, 99)), ("max", column.max()))
    }


def _gravity(robot: Robot, posture: NDArray[np.float64]) -> NDArray[np.float64]:
    from robotskin.model import RobotDynamics

    dynamics = RobotDynamics(robot.core)
    dynamics.update(posture, np.zeros(robot.joint_count))
    return dynamics.gravity_torque


def _touched(cells: int, rng: np.random.Generator, share: float) -> SkinState:
    state = SkinState(cells)
    state.health[:] = Health.alive.value
    touched = rng.uniform(size=cells) < share
    state.normal_force[touched] = rng.uniform(0, 2, (int(touched.sum()), 3))
    state.proximity[touched] = rng.uniform(0, 0.3, int(touched.sum()))
    return state


def _posture(robot: RobotModel, rng: np.random.Generator) -> NDArray[np.float64]:
    return rng.uniform(np.maximum(robot.lower, -1), np.minimum(robot.upper, 1))


def _skin_times(robot: RobotModel, skin: SkinModel, rng: np.random.Generator, rounds: int) -> dict[str, float]:
    gains = SkinGains.uniform(len(skin), 3.0, 20.0, 0.35, 0.9, 0.02, 0.05)
    posture = _posture(robot, rng)
    states = _touched(len(skin), rng, 1.0), _touched(len(skin), rng, 1.0)
    time_skin_task(robot, skin, gains, *states, posture, 20)
    times = time_skin_task(robot, skin, gains, *states, posture, rounds)
    return {name: float(np.median(values)) / 1e3 for name, values in times.items()}


def _repeated(skin: SkinModel, cells: int) -> SkinModel:
    """The same skin over and over, its cells still in the order of their links."""
    index = np.sort(np.resize(np.arange(len(skin)), cells))
    return SkinModel(
        link_names=skin.link_names,
        key=np.arange(1, cells + 1, dtype=np.uint32),
        link=skin.link[index],
        link_from_cell=skin.link_from_cell[index],
        neighbours=np.tile(np.array([-1, 0], dtype=np.int32), (cells, 4, 1)),
        patch=np.full(cells, -1, dtype=np.int32),
    )
