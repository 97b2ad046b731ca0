# SPDX-License-Identifier: Apache-2.0
"""Force sensors of a mounted skin, calibrated by the robot's own joint torques, and by a probe."""

from __future__ import annotations

from typing import Annotated

import numpy as np
import typer
from numpy.typing import NDArray
from scipy.stats import chi2

from robotskin import robots
from robotskin.calibration import Calibration, Known, Presses, calibrate
from robotskin.calibration.force_sensors import PARAMETERS, Array, felt
from robotskin.calibration.post import AtPost, postures_at_post
from robotskin.layout.finished_layouts import finished
from robotskin_lab.bench.calibration_rig import Rig, raw
from robotskin_lab.bench.progress import tell_step

Figures = dict[str, float | int | str]
TORQUE_NOISE_NM, FRICTION_KNOWN_TO = 0.2, 0.2
CHECKS = 12
CHECK_N = (0.5, 10.0)
POST_M, POST_RADIUS_M = 0.25, 0.01
ROUNDS = 4


def run(
    *,
    seed: Annotated[int, typer.Option(help="Of sensors, presses and errors.", min=0)] = 1,
    robot: Annotated[str, typer.Option(help="By name.")] = "ur5",
    draws: Annotated[int, typer.Option(help="Postures that are drawn for the post.", min=100)] = 10000,
    post_m: Annotated[float, typer.Option(help="Distance of the post's axis from the base's, metres.")] = POST_M,
    rounds: Annotated[int, typer.Option(help="So many times each cell is pressed at each place.", min=1)] = ROUNDS,
) -> Figures:
    """Calibrate cells with gains ±20 %, offsets ±0.2 N and crosstalk 5 % on the sensor models of the imperfect world.

    The robot presses each cell that it can bring to a fixed bar of 20 mm, in and out, `rounds` times. Its torques have
    0.2 Nm of noise a reading; friction is known to 20 %, levers to 1 %, the place to 1 mm, each drawn once. Then other
    forces at other places are felt: `calibration_rmse_n` is of a cell's force, `calibration_sensor_rmse_n` of one
    sensor's. Uncalibrated forces have their zero taken. `calibration_nees_within_95` is the share of cells whose twelve
    numbers are within the 95 % region of their covariance; `calibration_pressed_s` is the time that a cell takes.
    Figures of a probe of known force begin with `probe_`.
    """
    machine, layout = robots.load(robot), finished(robot)
    tell_step("postures at the post")
    at_post = postures_at_post(machine, layout, distance_m=post_m, radius_m=POST_RADIUS_M, draws=draws, seed=seed)
    rig = Rig(layout, seed)
    friction = raw().joint_friction * np.where(np.isfinite(machine.effort_limit), machine.effort_limit, 0.0)
    unknown = friction * FRICTION_KNOWN_TO
    mean = 1 / np.sqrt(rounds)
    known = Known(
        torque_nm=TORQUE_NOISE_NM * mean, before_nm=Known.before_nm * mean, friction_nm=tuple(unknown / np.sqrt(3))
    )
    drawn = rig.draw.uniform(-unknown, unknown)
    pressed = [by_torques(rig, machine, one, drawn, rounds) for one in at_post.values()]
    mounted = calibrate(layout, pressed, known, method="pressed against a fixed post, joint torques as the reference")
    tell_step("probe")
    known = Known()
    probe = calibrate(layout, [rig.by_probe(cell) for cell in range(len(layout))], known, method="probe of known force")
    tell_step("checks")
    cells = mounted.calibrated
    truth = rig.true_parameters()
    figures: Figures = {"calibration_cells": len(layout), "calibration_share": round(mounted.share, 4)}
    figures["calibration_pressed_s"] = round(rig.mounted_s / max(len(at_post), 1), 1)
    figures |= judged("calibration_", rig, mounted, truth, cells)
    figures |= judged("probe_", rig, probe, truth, probe.calibrated)
    tell_step("")
    return figures


def by_torques(rig: Rig, machine: robots.Robot, one: AtPost, friction_nm: Array, rounds: int) -> Presses:
    """Press one cell."""
    tell_step(f"cell {one.cell} of {rig.cells} at the post")
    return rig.by_torques(one, machine, friction_nm, TORQUE_NOISE_NM, rounds)


def judged(prefix: str, rig: Rig, calibration: Calibration, truth: Array, cells: NDArray[np.bool_]) -> Figures:
    """Errors of forces that were not calibrated with, and of the parameters against their covariance."""
    of_force, of_sensor, raw_force, raw_sensor = [], [], [], []
    for cell in np.flatnonzero(cells):
        for _ in range(CHECKS):
            place = rig.draw.uniform(-0.008, 0.008, 2)
            force = rig.pressed(int(cell), rig.draw.uniform(*CHECK_N), place)
            reading = rig.read(force, 0.05)[cell]
            true = force[cell]
            calibrated = np.maximum(felt(calibration.parameters[cell], reading), 0)
            tared = np.maximum(reading - rig.rest_n[cell], 0)
            of_sensor += list(calibrated - true)
            raw_sensor += list(tared - true)
            of_force.append((calibrated - true).sum())
            raw_force.append((tared - true).sum())
    error = (calibration.parameters - truth)[cells]
    nees = np.einsum("ni,nij,nj->n", error, np.linalg.inv(calibration.covariance[cells]), error)
    rmse, before = _rms(of_force), _rms(raw_force)
    return {
        f"{prefix}rmse_n": rmse,
        f"{prefix}uncalibrated_rmse_n": before,
        f"{prefix}rmse_ratio": round(rmse / before, 4),
        f"{prefix}sensor_rmse_n": _rms(of_sensor),
        f"{prefix}uncalibrated_sensor_rmse_n": _rms(raw_sensor),
        f"{prefix}gain_rmse": _rms(error[:, :3]),
        f"{prefix}nees_within_95": round(float((nees < chi2.ppf(0.95, PARAMETERS)).mean()), 4),
        f"{prefix}nees_mean": round(float(nees.mean() / PARAMETERS), 4),
    }


def _rms(values: object) -> float:
    return round(float(np.sqrt(np.mean(np.square(np.asarray(values))))), 4)
