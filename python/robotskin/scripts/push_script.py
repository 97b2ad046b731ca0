# SPDX-License-Identifier: Apache-2.0
"""The scripted demonstration: the same pushes through each interface, and figures that tell whether they were felt."""

from __future__ import annotations

import time
from collections.abc import Callable, Sequence

import numpy as np

from robotskin.figures import Bound, share_told
from robotskin.session import INTERFACES, PERIOD_S, Session
from robotskin.session.reasons import interventions_told
from robotskin.session.touches import (
    bearable_force,
    edge_of_patch,
    flat_seam,
    lean,
    own_give,
    press,
    push_and_release,
    pushed_cell,
)

FORCE_N = 15.0
HOLD_S = 2.0
TIME_CONSTANTS = 4.5
"""A robot that answers slowly is held for so many of its time constants: 1 % of the way is left then."""
PRESS_N = 10.0
MOST_FORCE_ERROR = 0.10
"""Of the contact force. Each cell feels only what acts along its own normal, late by its hysteresis, at its own scale
(docs/imperfections.md)."""
MOST_INTERVENTIONS = 0.01
"""Share of the ticks: gains that ask for more than that do not suit the robot."""
UNFELT_M, UNFELT_GIVE = 0.005, 2.0
"""A push that is not felt moves a cell by at most so many metres, or so many times what the joints' own stiffness
gives: a force that comes at once swings a spring to twice the way that it holds. A robot on feet leans besides."""

Progress = Callable[[str], None]


def bounds(figures: dict[str, float], interfaces: Sequence[str] = INTERFACES) -> list[Bound]:
    """What must hold of the figures of a robot with these interfaces."""
    found = [Bound("force_balance_error", most=MOST_FORCE_ERROR)]
    for interface in interfaces:
        unfelt_m = max(UNFELT_M, UNFELT_GIVE * figures[f"{interface}_own_give_m"] + figures.get("lean_m", 0.0))
        found += [
            Bound(f"{interface}_displacement_error", most=0.10),
            Bound(f"{interface}_event_displacement_error", most=0.10),
            Bound(f"{interface}_displacement_skin_off_m", most=unfelt_m),
            Bound(f"{interface}_displacement_masked_m", most=unfelt_m),
            Bound(f"{interface}_return_error_rad", most=0.02),
            Bound(f"{interface}_limit_violations", 0, 0),
        ]
    return [*found, Bound("intervention_share", most=MOST_INTERVENTIONS), Bound("frames_lost", 0, 0)]


def remarks(session: Session, figures: dict[str, float]) -> list[str]:
    """Why commands were changed, in a sentence; none where none was."""
    told = interventions_told(session.controller.intervention_counts, session.robot.joint_names)
    share = share_told(figures["intervention_share"])
    return [f"the guard changed {share} of the commands: {told}"] if told else []


def hold_s(session: Session) -> float:
    """Seconds after which a touched robot stands, and after which one that was let go is back."""
    return max(HOLD_S, TIME_CONSTANTS * float(session.gains.values["virtual_robot"]["friction_s"]))


def run(session: Session, link: str, seconds: float, progress: Progress = lambda _text: None) -> dict[str, float]:
    """Boot the session, push the robot through every interface, and measure.

    Args:
        session: fresh, not booted.
        link: whose cells are pushed.
        seconds: simulated seconds for each interface; what the script leaves over is filled with random touches.
        progress: told what happens next.
    """
    started = time.perf_counter()
    figures: dict[str, float] = {}
    progress("boot")
    figures["boot_s"] = session.boot()
    figures["formation_ms"] = 1e3 * (session.world.formation_s or float("nan"))
    missing_at_boot = session.frames_lost
    cell = pushed_cell(session, link)
    figures["pushed_cell"] = cell
    # A finger is not pushed as hard as an arm.
    force_n = figures["push_n"] = min(FORCE_N, bearable_force(session, cell))
    for interface in session.interfaces:
        figures[f"{interface}_own_give_m"] = own_give(session, cell, force_n, interface)
    if leans_m := lean(session, cell, force_n):
        figures["lean_m"] = leans_m
    errors = []
    for interface in session.interfaces:
        figures |= _interface_figures(session, interface, cell, force_n, seconds, progress)
        progress(f"{interface}: presses on a cell, a seam and an edge")
        errors += _force_errors(session, cell, link, min(PRESS_N, force_n))
    figures["force_balance_error"] = max(errors)
    figures["frames_lost"] = session.frames_lost - missing_at_boot
    figures["simulated_s"] = session.world.time_s
    figures["intervention_share"] = session.controller.report.interventions / (session.world.time_s / PERIOD_S)
    figures["realtime_factor"] = session.world.time_s / (time.perf_counter() - started)
    return figures


def _interface_figures(
    session: Session, interface: str, cell: int, force_n: float, seconds: float, progress: Progress
) -> dict[str, float]:
    began = session.world.time_s
    violations = session.controller.report.violations
    session.set_interface(interface)
    hold = hold_s(session)
    session.run(hold)  # to where the nearness of its own links leaves it

    progress(f"{interface}: push with the skin on")
    on = push_and_release(session, cell, force_n, hold, hold)
    session.set_mode("event")
    session.run(0.5)
    progress(f"{interface}: the same in event mode")
    event = push_and_release(session, cell, force_n, hold, hold)
    session.set_mode("clock")
    session.set_skin(False)
    session.run(hold)  # what it saw of itself no longer pushes it aside
    progress(f"{interface}: the same with the skin off")
    off = push_and_release(session, cell, force_n, HOLD_S, rest_s=1.0)
    session.set_skin(True)
    patch = int(session.layout.patch[cell])
    session.mask_patch(patch, True)
    session.run(hold)
    progress(f"{interface}: the same with the patch masked")
    masked = push_and_release(session, cell, force_n, HOLD_S, rest_s=1.0)
    session.mask_patch(patch, False)
    session.run(0.5)

    progress(f"{interface}: random touches")
    _touch_at_random(session, began + seconds)
    return {
        f"{interface}_displacement_m": on.displacement_m,
        f"{interface}_displacement_error": abs(on.displacement_m / on.expected_m - 1),
        f"{interface}_event_displacement_error": abs(event.displacement_m / event.expected_m - 1),
        f"{interface}_peak_displacement_m": on.peak_m,
        f"{interface}_event_displacement_m": event.displacement_m,
        f"{interface}_displacement_skin_off_m": off.peak_m,
        f"{interface}_displacement_masked_m": masked.peak_m,
        f"{interface}_return_error_rad": max(on.return_error_rad, event.return_error_rad),
        f"{interface}_limit_violations": session.controller.report.violations - violations,
    }


def _force_errors(session: Session, cell: int, link: str, force_n: float) -> list[float]:
    session.set_skin(False)
    session.run(0.5)
    places = [(cell, (0.0, 0.0)), flat_seam(session, link), edge_of_patch(session, link)]
    presses = [press(session, place[0], force_n, place[1]) for place in places if place is not None]
    session.set_skin(True)
    session.run(0.5)
    return [measured.relative_error for measured in presses]


def _touch_at_random(session: Session, until_s: float) -> None:
    generator = np.random.default_rng([session.seed, round(1e3 * session.world.time_s)])
    while session.world.time_s < until_s - 1.5:
        cell = int(generator.integers(len(session.layout)))
        force_n = min(float(generator.uniform(2.0, 20.0)), bearable_force(session, cell))
        session.world.push(session.in_world(cell), force_n)
        session.run(min(float(generator.uniform(0.5, 1.5)), until_s - 1.5 - session.world.time_s))
        session.world.release()
        session.run(0.3)
    session.world.release()
    session.run(max(until_s - session.world.time_s, 0.0))
