# SPDX-License-Identifier: Apache-2.0
"""The headless run: hands push the standing robot at its arms and chest, through firmware, network and driver."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
from numpy.typing import NDArray

from robotskin.cycle import SafetyState
from robotskin.figures import Bound
from robotskin.session import Session
from robotskin.session.touches import expected_displacement, turn_by_touch

Progress = Callable[[str], None]

LINKS = ("torso_2_link", "arm_left_4_link", "arm_right_2_link")
"""Pushed one after the other."""
FORCE_N = 15.0
"""What a cell feels in full wherever it is pressed."""
HOLD_S, REST_S = 1.0, 0.6
FALLEN_SHARE = 0.8
"""Of the height of its base at home."""


def bounds() -> list[Bound]:
    """What must hold."""
    return [
        Bound("stands", 1, 1),
        Bound("running", 1, 1),
        Bound("limit_violations", 0, 0),
        Bound("give_mm_per_n", 0.2, 25.0),
        Bound("give_over_gains", 0.35, 1.2),
        Bound("capture_inside_mm", least=10.0),
        Bound("base_error_mm", most=30.0),
    ]


def drawn_cell(session: Session, link: str, generator: np.random.Generator) -> int:
    """A cell of the link that a hand can reach: inside of its patch."""
    layout = session.layout
    inside = (layout.neighbours[:, :, 0] >= 0).sum(axis=1) >= 3
    return int(generator.choice(np.flatnonzero((layout.link == layout.links.index(link)) & inside)))


def run(session: Session, pushes: int, progress: Progress = lambda _text: None) -> dict[str, float]:
    """Boot, push one link after the other, let go, and measure.

    Figures: `give_mm_per_n`, the mean way of a pushed cell for a newton of the hand, in a second; `give_over_gains`,
    the way of all of them over what the gains say for what the skin feels then, once at rest; `lean_mm`, the
    furthest that the estimated centre of mass went over the floor from where it was before the first push;
    `capture_inside_mm`, the least distance of the capture point from the edge of the soles; `base_error_mm`, the most
    between the estimated and the true base; `stands`; `running`, 1 if the guard never stopped it. All but the gives
    and `stands` are looked at in every period of the pushes and of the rests after them.
    """
    progress("boot")
    figures = {"boot_s": session.boot()}
    generator = np.random.default_rng([session.seed, 18])
    gives: list[float] = []
    gave = says = 0.0
    inside, lean, error = np.inf, 0.0, 0.0
    begun: NDArray[np.float64] | None = None
    running = True
    for number in range(pushes):
        cell = drawn_cell(session, LINKS[number % len(LINKS)], generator)
        progress(f"push {number + 1} of {pushes}")
        before, turned = session.cell_position(cell), turn_by_touch(session)
        session.world.push(session.in_world(cell), FORCE_N)
        for tick in range(round((HOLD_S + REST_S) * 1000)):
            if tick == round(HOLD_S * 1000):
                force = float(session.world.contact_normal_force()[0])
                if force > 0.5 * FORCE_N:
                    way = float(np.linalg.norm(session.cell_position(cell) - before))
                    gives.append(1e3 * way / force)
                    gave, says = gave + way, says + expected_displacement(session, cell, turned)
                session.world.release()
            session.step()
            error = max(error, base_error_m(session))
            standing = session.controller.cycle.standing
            if standing is None:
                continue
            centre = np.array(standing.centre_of_mass)[:2]
            begun = centre if begun is None else begun
            lean = max(lean, float(np.linalg.norm(centre - begun)))
            inside = min(inside, standing.support.inside_by(standing.capture_point))
            running = running and session.state in (SafetyState.running, SafetyState.degraded)
    return figures | {
        "give_mm_per_n": float(np.mean(gives)) if gives else 0.0,
        "give_over_gains": gave / says if says else 0.0,
        "lean_mm": 1e3 * lean,
        "capture_inside_mm": 1e3 * float(inside),
        "base_error_mm": 1e3 * error,
        "limit_violations": session.controller.report.violations,
        "stands": float(session.world.joint_positions()[2] > FALLEN_SHARE * session.home[2]),
        "running": float(running),
        "simulated_s": session.world.time_s,
    }


def base_error_m(session: Session) -> float:
    """Metres between the base as it is estimated and as it is."""
    return float(np.linalg.norm(session.world.joint_positions()[:3] - np.array(session.joints.position)[:3]))
