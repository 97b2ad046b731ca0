# SPDX-License-Identifier: Apache-2.0
"""`robotskin bench selfconfig`, the whole: computing time for 700 cells, and what the robot does on what it found."""

from __future__ import annotations

import time

import numpy as np
from scipy.linalg import cholesky

from robotskin.configuring.configured import configured
from robotskin.layout.finished_layouts import finished
from robotskin.layout.layout import Layout
from robotskin.robots import Robot, load
from robotskin.robots.free_space import FreeSpace
from robotskin.selfconfig.babbling.plan import plan_babbling
from robotskin.selfconfig.configuration import Configuration
from robotskin.selfconfig.configure import configure
from robotskin.selfconfig.kinematics.configured_kinematics import against_nominal
from robotskin.selfconfig.learned_map import learn_map
from robotskin.selfconfig.reconstruction.accuracy import mean_errors
from robotskin.selfconfig.simulated.recording import simulate_babbling
from robotskin.session import INTERFACES, Session
from robotskin.session.touches import push_and_release, pushed_cell
from robotskin.session.worn_cells import cells_in

Figures = dict[str, float]

FORCE_N = 15.0
REFERENCE_SIZE = 3000


def configure_figures(seed: int) -> Figures:
    """All computing from a recording of the dual-arm robot in 700 cells to its model and map; motion not counted."""
    robot, layout = load("dual_arm"), finished("dual_arm")
    random = np.random.default_rng(seed)
    plan = plan_babbling(FreeSpace(robot), robot.neutral, random)
    recording = simulate_babbling(robot, layout, plan, random)
    reference = _reference_s()
    start, began_cpu_s = time.perf_counter(), time.process_time()
    found = configure(robot, recording)
    learn_map(robot, recording, found)
    seconds, cpu_s = time.perf_counter() - start, time.process_time() - began_cpu_s
    figures = _against_truth(robot, layout, found)
    return {
        "configure_compute_s": seconds,
        "configure_compute_cpu_s": cpu_s,
        "configure_compute_in_choleskys_of_3000": seconds / reference,
        **{f"configure_{step}_s": spent for step, spent in found.seconds.items()},
        **{f"configure_{key}": value for key, value in figures.items()},
    }


def _reference_s() -> float:
    """Time of a dense Cholesky factorisation, the best of three."""
    matrix = np.random.default_rng(0).standard_normal((REFERENCE_SIZE, REFERENCE_SIZE))
    matrix = matrix @ matrix.T + REFERENCE_SIZE * np.eye(REFERENCE_SIZE)
    spent = []
    for _ in range(3):
        start = time.perf_counter()
        cholesky(matrix, lower=True, check_finite=False)
        spent.append(time.perf_counter() - start)
    return min(spent)


def _against_truth(robot: Robot, layout: Layout, found: Configuration) -> Figures:
    """Errors of what was found: cells, and axes of the skin's own kinematics."""
    estimated = found.layout()
    rotation_deg, position_mm = mean_errors(
        estimated.link_from_cell, layout.link_from_cell[cells_in(layout, estimated)]
    )
    figures = {
        "placed_share": len(estimated) / len(layout),
        "rotation_deg": rotation_deg,
        "position_mm": position_mm,
    }
    if found.kinematics is not None:
        axes = against_nominal(found.kinematics, robot)
        figures["axis_deg"] = float(np.degrees(max(axis.angle_rad for axis in axes)))
        figures["axis_mm"] = 1e3 * max(axis.distance_m for axis in axes)
    return figures


def displacement_figures(seed: int) -> Figures:
    """A UR5 finds its skin through firmware, network and driver, then is pushed: on what it found, and on the truth."""
    robot, layout = load("ur5"), finished("ur5")
    start = time.perf_counter()
    own = configured(robot, layout, seed)
    explored_s = time.perf_counter() - start - sum(own.configuration.seconds.values())
    moved: dict[str, dict[str, float]] = {}
    pushed = -1
    for name, model, control in (("true", None, None), ("configured", own.layout, own.robot)):
        session = Session(robot, layout, seed=seed, link="in process", estimated_layout=model, control=control)
        session.boot()
        if pushed < 0:
            pushed = session.in_world(pushed_cell(session, "forearm_link"))
        cell = int(np.flatnonzero(session.world_cells == pushed)[0])
        moved[name] = {}
        for interface in INTERFACES:
            session.set_interface(interface)
            session.run(0.5)
            moved[name][interface] = push_and_release(session, cell, FORCE_N).displacement_m
        session.shut_down()
    ratios = {interface: moved["configured"][interface] / moved["true"][interface] for interface in INTERFACES}
    figures = _against_truth(robot, layout, own.configuration)
    return {
        "configured_displacement_ratio": max(ratios.values(), key=lambda ratio: abs(ratio - 1)),
        **{f"configured_{interface}_displacement_ratio": ratio for interface, ratio in ratios.items()},
        "explore_motion_s": own.duration_s,
        "explore_wall_s": explored_s,
        **{f"explored_{key}": value for key, value in figures.items()},
    }
