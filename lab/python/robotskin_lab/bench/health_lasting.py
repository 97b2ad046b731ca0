# SPDX-License-Identifier: Apache-2.0
"""A constant touch through the whole chain: what the skin makes of it in the end, and what its sensors did."""

from __future__ import annotations

from typing import Any

import numpy as np

from robotskin import layout
from robotskin.calibration import Calibration, ZeroWatch
from robotskin.calibration.force_sensors import PARAMETERS, UNTOUCHED, Array
from robotskin.health import HealthWatch, work
from robotskin.robots.gains import robot_with_gains
from robotskin.session import Session
from robotskin.skin import Health

FORCE_N = 5.0
FIRST_S = 5.0
MEAN_S = 2.0
LOOK_S, NEAR_M = 1.0, 0.05
POSTURE = "skin_compliance"


def lasting_figures(robot: str, seed: int, seconds: float) -> dict[str, Any]:
    """One cell of a robot that holds still is pressed with 5 N all the time, while its health is watched, ill cells are
    left out and zeros are followed."""
    ready = robot_with_gains(robot, None)
    worn = layout.finished(robot)
    session = Session(ready.robot, worn, POSTURE, seed=seed, gains=ready.gains, link="in process")
    session.set_skin(False)
    session.boot()
    try:
        return _pressed(session, seconds)
    finally:
        session.shut_down()


def _pressed(session: Session, seconds: float) -> dict[str, Any]:
    cells = len(session.layout)
    cell = int(np.random.default_rng([session.seed, 73]).integers(cells))
    watch = HealthWatch(session.layout.skin_model(), session.robot.core, layout=session.layout)
    rest_n = np.asarray(session.reader.measured_force, dtype=float).copy()
    zeros = ZeroWatch(_uncalibrated(session, rest_n))
    session.world.push(session.in_world(cell), FORCE_N)
    told: list[tuple[float, float, float]] = []
    looked_s, begun_s = 0.0, session.world.time_s
    while (time_s := session.world.time_s - begun_s) < seconds:
        session.step()
        measured = np.asarray(session.reader.measured_force, dtype=float)
        told.append((time_s, float(np.asarray(session.skin.normal_force)[cell].sum()), float(measured[cell].sum())))
        if work.look(watch, session):
            session.leave_out(finding.cell for finding in watch.findings)
        if time_s - looked_s >= LOOK_S:
            zeros.look(measured, _untouched(session), time_s - looked_s)
            looked_s = time_s
    table = np.array(told)
    first = table[(table[:, 0] > FIRST_S) & (table[:, 0] < FIRST_S + MEAN_S)].mean(axis=0)
    last = table[table[:, 0] > table[-1, 0] - MEAN_S].mean(axis=0)
    felt, own = last[1] - first[1], last[2] - first[2]
    return {
        "lasting_touch_s": float(table[-1, 0]),
        "lasting_touch_percent": 100 * abs(felt - own) / FORCE_N,
        "lasting_touch_own_percent": 100 * own / FORCE_N,
        "lasting_touch_zero_moved_percent": 100 * float(np.abs(zeros.drift_n[cell]).sum()) / FORCE_N,
        "lasting_touch_named_ill": int(any(finding.cell == cell for finding in watch.findings)),
    }


def _untouched(session: Session) -> np.ndarray:
    """(N) as `robotskin calibrate --follow` has it."""
    near = np.append(np.asarray(session.skin.distance) < NEAR_M, False)
    beside = session.layout.neighbours[:, :, 0]
    return ~(near[:-1] | near[beside].any(axis=1)) & (np.asarray(session.skin.health) == int(Health.alive))


def _uncalibrated(session: Session, rest_n: Array) -> Calibration:
    """Gains of one, and the zeros at rest."""
    cells = len(session.layout)
    parameters = np.tile(UNTOUCHED, (cells, 1))
    parameters[:, 3:6] = rest_n
    covariance = np.tile(1e-4 * np.eye(PARAMETERS), (cells, 1, 1))
    return Calibration.of(
        session.layout, parameters, covariance, np.ones(cells, bool), date="2026-01-01", method="zeros at rest"
    )
