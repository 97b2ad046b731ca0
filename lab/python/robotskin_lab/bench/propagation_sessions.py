# SPDX-License-Identifier: Apache-2.0
"""Whole sessions of force propagation: pushes and a palm that comes near, through firmware, network and driver."""

from __future__ import annotations

import numpy as np

from robotskin import robots
from robotskin.apps.propagate.script import Plan, base_m, run
from robotskin.apps.propagate.tasks import WITH, use_arms_alone
from robotskin.layout import finished
from robotskin.session import Session
from robotskin.world import Hand
from robotskin_lab.bench.progress import tell
from robotskin_lab.bench.propagation_rig import ROBOT, drawn_cells
from robotskin_lab.bench.random_touches import RandomTouches

FORCE_N = 8.0
PALM_M = 0.003
TOUCH_N = 15.0
"""The most of a touch of the soak."""
AWAY_M, AWAY_M_S = 0.3, 0.1
"""So a hand is drawn back after a touch: no faster than the arm whose way it may cross can yield."""


def whole_session(seed: int) -> Session:
    """The dual-arm robot by velocity, booted."""
    session = Session(robots.load(ROBOT), finished(ROBOT), WITH, seed=seed, interface="velocity", link="in process")
    session.boot()
    return session


def session_figures(seed: int, count: int) -> dict[str, float]:
    """Each of `count` cells pushed with the base and without, then approached by a palm; the worst of each counts."""
    moved = {True: 0.0, False: 0.0}
    back = peak = violations = stopped = 0.0
    near: list[float] = []
    for index, cell in enumerate(drawn_cells(seed + 1000, count)):
        for base in (True, False):
            tell(f"sessions: cell {cell}, {'with' if base else 'without'} the base")
            session = whole_session(seed + index)
            try:
                if not base:
                    use_arms_alone(session)
                    session.run(0.3)
                figures = run(session, Plan(int(cell), FORCE_N, 1.0, 10.0 if base else 0.5))
            finally:
                session.shut_down()
            moved[base] += figures["moved_mm"]
            peak = max(peak, figures["peak_contact_n"])
            violations += figures["limit_violations"]
            stopped += 1 - figures["running"]
            if base:
                back = max(back, figures["base_back_mm"])
    tell("sessions: a palm comes near")
    session = whole_session(seed)
    try:
        shoulder = next(
            c for c, link in enumerate(session.layout.link) if session.layout.links[link] == "right_shoulder_link"
        )
        session.world.approach(session.in_world(shoulder), PALM_M)
        start = session.cell_position(shoulder)
        touched = 0.0
        for _ in range(4000):
            session.step()
            touched = max(touched, float(session.world.contact_normal_force().sum()))
        near = [1e3 * base_m(session), 1e3 * float(np.linalg.norm(session.cell_position(shoulder) - start)), touched]
    finally:
        session.shut_down()
    return {
        "session_cells": float(count),
        "session_gain": moved[True] / moved[False],
        "session_base_back_mm": back,
        "session_peak_contact_n": peak,
        "session_violations": violations,
        "session_stops": stopped,
        "palm_base_mm": near[0],
        "palm_cell_mm": near[1],
        "palm_contact_n": near[2],
    }


class DrawnBack(Hand):
    """A hand of the world that leaves slowly. Its way is a cell's normal, and turns as the robot yields."""

    def leave(self) -> None:
        """Go back along the normal of the cell that was touched."""
        self.approach(self.cell, AWAY_M, AWAY_M_S)


def soak_figures(seed: int, seconds: float) -> dict[str, float]:
    """Random touches of up to `TOUCH_N` while the robot complies; then one push more, to see that it goes on."""
    session = whole_session(seed)
    try:
        touches = RandomTouches(session, range(len(session.layout)), TOUCH_N, seed)
        touches.hand = DrawnBack(session.world, touches.hand.index)

        def run_until(time_s: float) -> None:
            while session.world.time_s < time_s:
                session.step()
                touches.step()

        while session.world.time_s < seconds:
            tell(f"soak: {session.world.time_s:.0f} of {seconds:.0f} s")
            run_until(min(session.world.time_s + 10.0, seconds))
        touches.end()
        session.world.release()
        run_until(session.world.time_s + 10.0)
        cell = next(
            c for c, link in enumerate(session.layout.link) if session.layout.links[link] == "right_shoulder_link"
        )
        after = run(session, Plan(cell, FORCE_N, 0.5, 0.0))
        interventions = float(session.controller.report.interventions)
    finally:
        session.shut_down()
    return {
        **{key.removeprefix("arms_"): value for key, value in touches.figures("arms").items()},
        "soak_s": seconds,
        "soak_interventions": interventions,
        "soak_moved_after_mm": after["moved_mm"],
    }
