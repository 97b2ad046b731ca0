# SPDX-License-Identifier: Apache-2.0
"""`robotskin bench control`, endurance: every behaviour under random touches, on the paper's three pairings."""

from __future__ import annotations

from collections.abc import Iterable

import numpy as np

from robotskin.control import BEHAVIOURS
from robotskin.session import SafetyState, Session
from robotskin.session.touches import bearable_force, is_reached
from robotskin_lab.bench.control_chain import chain
from robotskin_lab.bench.progress import tell

PAIRINGS = (("allegro_right_hand", "torque"), ("dual_arm", "velocity"), ("talos", "position"))
"""Robot and interface (V-A, V-B, V-D)."""
FORCE_N = (1.0, 15.0)
HELD_S, PAUSE_S = (0.3, 1.5), (0.1, 0.8)
LOOK_S = 0.02
"""How often the hand looks at what the joints bear: a lever grows as the robot gives way."""


def touch(session: Session, cell: int, force_n: float, seconds: float) -> None:
    """Push a cell for a time, to a fiftieth of a second, never harder than the joints bear, and let go."""
    for _ in range(max(1, round(seconds / LOOK_S))):
        session.world.push(session.in_world(cell), min(force_n, bearable_force(session, cell)))
        session.run(LOOK_S)
    session.world.release()


def soak_figures(
    seed: int,
    seconds: float,
    pairings: Iterable[tuple[str, str]] = PAIRINGS,
    behaviours: Iterable[str] = tuple(BEHAVIOURS),
) -> dict[str, float]:
    """`soak_violations`: cycles in which a robot was beyond a limit; `soak_stops`: runs that the guard ended;
    `soak_covered`: cells that were drawn and not touched.

    Each behaviour runs `seconds` simulated seconds on each pairing, touched by a hand with 1 to 15 N at one cell after
    the other, with pauses. The hand pushes no harder than the joints bear where the robot is by then, for motors that
    are overrun hold no limit; and it pushes no cell that another part of the robot covers, where it has no room.
    """
    violations = stops = interventions = touches = covered = 0
    simulated = 0.0
    for robot, interface in pairings:
        for index, behaviour in enumerate(behaviours):
            session = chain(robot, behaviour, interface, seed)
            session.boot()
            rng = np.random.default_rng([seed, index])
            begins = session.world.time_s
            ends = begins + seconds
            while session.world.time_s < ends and session.state in (SafetyState.running, SafetyState.degraded):
                cell = int(rng.integers(len(session.layout)))
                if not is_reached(session, cell):
                    covered += 1
                    session.run(PAUSE_S[0])
                    continue
                touch(session, cell, float(rng.uniform(*FORCE_N)), float(rng.uniform(*HELD_S)))
                session.run(float(rng.uniform(*PAUSE_S)))
                touches += 1
            report = session.controller.report
            running = session.state in (SafetyState.running, SafetyState.degraded)
            end = "running" if running else f"stopped: {session.why_not_running()}"
            lasted = session.world.time_s - begins
            tell(f"soak: {robot}, {behaviour}: {lasted:.0f} s, {report.violations} violations, {end}")
            violations += report.violations
            interventions += report.interventions
            stops += not running
            simulated += min(lasted, seconds)
            session.shut_down()
    tell("")
    return {
        "soak_violations": float(violations),
        "soak_stops": float(stops),
        "soak_interventions": float(interventions),
        "soak_touches": float(touches),
        "soak_covered": float(covered),
        "soak_s": simulated,
        "soak_behaviour_s": seconds,
    }
