# SPDX-License-Identifier: Apache-2.0
"""Compliance of the skinned UR5 with the torque from the host and from the skin, in one run."""

from __future__ import annotations

from typing import Any

import numpy as np

from robotskin import robots
from robotskin.layout import finished
from robotskin.session import Session
from robotskin_lab.bench.progress import tell

FORCE_N = 5.0
LEAST_M = 5e-3
SETTLE_S = 2.0
LEAVE_S, STILL_M, LOOK_S, REST_MOST_S = 1.0, 2e-5, 0.25, 10.0


def compliance_figures(seed: int, pushes: int) -> dict[str, Any]:
    """Push cells all over the arm once with each source, and once more with the host, and compare how far they go.

    Displacements after two seconds of a push of 5 N; an error is the difference of two lengths over the host's. Cells
    that go by less than 5 mm are passed over. `again` is how well the host repeats itself. The arm comes back like a
    spring in honey, with a time constant of half a second: a push begins when it has come to rest, or it would begin on
    the way back from the last one.
    """
    session = Session(robots.load("ur5"), finished("ur5"), seed=seed, link="in process", cell_torques=True)
    session.boot()
    generator = np.random.default_rng(seed)
    cells = generator.permutation(len(session.layout))
    errors: list[float] = []
    again: list[float] = []
    lengths: list[float] = []
    torque_errors: list[float] = []
    controller = session.controller
    switched = 0
    rested = 0.0
    for cell in cells:
        if len(errors) == pushes:
            break
        moved: list[float] = []
        for source in ("host", "skin", "host"):
            tell(f"compliance: push {len(errors) + 1} of {pushes}, torque from the {source}")
            session.set_source(source)
            rested += _come_to_rest(session, int(cell))
            start = session.cell_position(int(cell))
            session.world.push(session.in_world(int(cell)), FORCE_N)
            session.run(SETTLE_S)
            moved.append(float(np.linalg.norm(session.cell_position(int(cell)) - start)))
            switched += int(controller.skin_source_share == (source == "skin"))
            if session.skin_computed_torque.fresh:
                host, own = np.asarray(controller.host_skin_torque), np.asarray(session.skin_computed_torque.joint)
                torque_errors.append(float(np.abs(own - host).max() / max(np.abs(host).max(), 1e-9)))
            session.world.release()
        if moved[0] < LEAST_M:
            continue
        lengths.append(moved[0])
        errors.append(abs(moved[1] - moved[0]) / moved[0])
        again.append(abs(moved[2] - moved[0]) / moved[0])
    statistics = session.driver.statistics()
    session.shut_down()
    tell("")
    return {
        "compliance_cells": len(session.layout),
        "compliance_pushes": len(errors),
        "compliance_displacement_mm": 1e3 * float(np.median(lengths)),
        "compliance_error_rel_median": float(np.median(errors)),
        "compliance_error_rel_max": max(errors),
        "compliance_again_rel_median": float(np.median(again)),
        "compliance_again_rel_max": max(again),
        "compliance_torque_error_rel_median": float(np.median(torque_errors)),
        "compliance_source_obeyed": switched,
        "compliance_rest_s": rested / max(len(torque_errors), 1),
        "compliance_vectors": int(statistics["torque_vectors"]),
        "compliance_vectors_partial": int(statistics["torque_partial"]),
    }


def _come_to_rest(session: Session, cell: int) -> float:
    """Run until a cell stands still; seconds."""
    began = session.world.time_s
    session.run(LEAVE_S)
    here = session.cell_position(cell)
    while session.world.time_s - began < REST_MOST_S:
        session.run(LOOK_S)
        before, here = here, session.cell_position(cell)
        if np.linalg.norm(here - before) < STILL_M:
            break
    return session.world.time_s - began
