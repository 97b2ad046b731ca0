# SPDX-License-Identifier: Apache-2.0
"""The skin task on Talos with 1260 cells: per-link products against a Jacobian a cell, and the bare product."""

from __future__ import annotations

from typing import Any

import numpy as np

from robotskin import robots
from robotskin.layout import finished
from robotskin.model import RobotDynamics
from robotskin.skin import Health, SkinState
from robotskin.tasks import SkinGains, TouchWrench
from robotskin_lab._lab.baselines import NaiveSkinTask, time_skin_task

ROBOT = "talos"
NAMES = {"task": "aggregate", "product": "product", "single": "single", "kinematics": "kinematics", "naive": "naive"}


def run(*, seed: int = 1, rounds: int = 20000) -> dict[str, Any]:
    """Time the skin task: every cell touched, thresholds, activation and joint torques included.

    `aggregate` is the task without the forward kinematics that every task shares (`kinematics`), `product` the bare
    6 x n product of as many cells in double precision in the same run, `single` that in single precision, `naive` a
    Jacobian a cell [Cheng19 eq. 16]. Median, 99 % and worst of all rounds; the ratio is between medians.
    """
    rng = np.random.default_rng(seed)
    robot = robots.load(ROBOT).core
    skin = finished(ROBOT).skin_model()
    gains = SkinGains.uniform(len(skin), 3.0, 20.0, 0.35, 0.9, 0.02, 0.05)
    state, other = _touched(len(skin), rng), _touched(len(skin), rng)
    posture = rng.uniform(np.maximum(robot.lower, -1), np.minimum(robot.upper, 1))
    time_skin_task(robot, skin, gains, state, other, posture, 1000)  # warms caches and clock
    times = time_skin_task(robot, skin, gains, state, other, posture, rounds)

    dynamics = RobotDynamics(robot)
    dynamics.update(posture, np.zeros(robot.joint_count))
    task = TouchWrench(robot, skin, gains)
    torque = task.compute(dynamics, state, np.ones(len(skin), dtype=np.float32))
    literal = NaiveSkinTask(robot, skin)
    naive = literal.compute(dynamics, task.magnitudes)
    # The task is single precision: its error is relative to what single cells ask for, not to what is left of it.
    asked = sum(np.abs(literal.compute(dynamics, magnitude)) for magnitude in np.diag(task.magnitudes))

    figures: dict[str, Any] = {"robot": ROBOT, "cells": len(skin), "rounds": rounds}
    for key, name in NAMES.items():
        nanoseconds = times[key]
        figures[f"{name}_us"] = float(np.median(nanoseconds)) / 1e3
        figures[f"{name}_p99_us"] = float(np.percentile(nanoseconds, 99)) / 1e3
        figures[f"{name}_max_us"] = float(nanoseconds.max()) / 1e3
    figures["aggregate_ratio"] = figures["aggregate_us"] / figures["product_us"]
    figures["naive_ratio"] = figures["naive_us"] / figures["aggregate_us"]
    figures["torque_max_nm"] = float(np.abs(torque).max())
    figures["torque_difference_nm"] = float(np.abs(torque - naive).max())
    figures["torque_error"] = float((np.abs(torque - naive) / np.maximum(asked, 1e-9)).max())
    return figures


def _touched(cells: int, rng: np.random.Generator) -> SkinState:
    state = SkinState(cells)
    state.health[:] = Health.alive.value
    state.normal_force[:] = rng.uniform(0, 5, (cells, 3))
    state.proximity[:] = rng.uniform(0, 1, cells)
    return state
