"""The skin task on Talos with 1260 cells: per-link products against a Jacobian a cell, and the bare product."""

from __future__ import annotations

from typing import Any

import numpy as np

from robotskin import robots
from robotskin._core.control import NaiveSkinTask, SkinGains, SkinTask, time_skin_task
from robotskin._core.model import RobotDynamics, RobotModel
from robotskin._core.skin import Health, SkinModel, SkinState

ROBOT = "talos_reduced"


def run(*, seed: int = 1, cells: int = 1260, rounds: int = 20000) -> dict[str, Any]:
    """Time the skin task: every cell touched, thresholds, activation and joint torques included.

    `aggregate` is the task without the forward kinematics that every task shares (`kinematics`), `product` the bare
    6 x n products of the same cells in the same run, `naive` a Jacobian a cell (eq. 16). Median, 99 % and worst of all
    rounds; the ratio is between medians.
    """
    rng = np.random.default_rng(seed)
    robot = robots.load(ROBOT).core
    skin, source = _skin(robot, cells, rng)
    gains = SkinGains.uniform(len(skin), 3.0, 20.0, 0.35, 0.9, 0.02, 0.05)
    state, other = _touched(len(skin), rng), _touched(len(skin), rng)
    posture = rng.uniform(np.maximum(robot.lower, -1), np.minimum(robot.upper, 1))
    time_skin_task(robot, skin, gains, state, other, posture, 1000)  # warms caches and clock
    times = time_skin_task(robot, skin, gains, state, other, posture, rounds)

    dynamics = RobotDynamics(robot)
    dynamics.update(posture, np.zeros(robot.joint_count))
    task = SkinTask(robot, skin, gains)
    torque = task.compute(dynamics, state, np.ones(len(skin), dtype=np.float32))
    naive = NaiveSkinTask(robot, skin).compute(dynamics, task.magnitudes)

    figures: dict[str, Any] = {"robot": ROBOT, "cells": len(skin), "layout": source, "rounds": rounds}
    for key, name in (("task", "aggregate"), ("product", "product"), ("kinematics", "kinematics"), ("naive", "naive")):
        nanoseconds = times[key]
        figures[f"{name}_us"] = float(np.median(nanoseconds)) / 1e3
        figures[f"{name}_p99_us"] = float(np.percentile(nanoseconds, 99)) / 1e3
        figures[f"{name}_max_us"] = float(nanoseconds.max()) / 1e3
    figures["aggregate_ratio"] = figures["aggregate_us"] / figures["product_us"]
    figures["naive_ratio"] = figures["naive_us"] / figures["aggregate_us"]
    figures["torque_max_nm"] = float(np.abs(torque).max())
    figures["torque_difference_nm"] = float(np.abs(torque - naive).max())
    return figures


def _skin(robot: RobotModel, cells: int, rng: np.random.Generator) -> tuple[SkinModel, str]:
    """Spread cells over all links that move, grouped by link as a layout has them."""
    moving = np.flatnonzero(robot.link_joints >= 0)
    pose = np.tile(np.eye(4), (cells, 1, 1))
    pose[:, :3, :3] = np.linalg.qr(rng.normal(size=(cells, 3, 3)))[0]
    pose[:, :3, 3] = rng.uniform(-0.1, 0.1, (cells, 3))
    skin = SkinModel(
        link_names=list(robot.link_names),
        key=np.arange(1, cells + 1, dtype=np.uint32),
        link=np.sort(rng.choice(moving, cells)).astype(np.int32),
        link_from_cell=pose,
        neighbours=np.tile(np.array([-1, 0], dtype=np.int32), (cells, 4, 1)),
        patch=np.zeros(cells, dtype=np.int32),
    )
    return skin, "random"


def _touched(cells: int, rng: np.random.Generator) -> SkinState:
    state = SkinState(cells)
    state.health[:] = Health.alive.value
    state.normal_force[:] = rng.uniform(0, 5, (cells, 3))
    state.proximity[:] = rng.uniform(0, 1, cells)
    return state
