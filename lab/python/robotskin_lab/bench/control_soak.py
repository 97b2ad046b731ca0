# SPDX-License-Identifier: Apache-2.0
"""`robotskin bench control`, endurance: every behaviour under random touches, on the paper's three pairings."""

from __future__ import annotations

from collections.abc import Iterable

import numpy as np

from robotskin.control import BEHAVIOURS
from robotskin.session import SafetyState
from robotskin.session.touches import bearable_force
from robotskin_lab.bench.control_chain import chain
from robotskin_lab.bench.progress import tell

PAIRINGS = (("allegro_right_hand", "torque"), ("dual_arm", "velocity"), ("talos", "position"))
"""Robot and interface (V-A, V-B, V-D)."""
FORCE_N = (1.0, 15.0)
HELD_S, PAUSE_S = (0.3, 1.5), (0.1, 0.8)


def soak_figures(
    seed: int,
    seconds: float,
    pairings: Iterable[tuple[str, str]] = PAIRINGS,
    behaviours: Iterable[str] = tuple(BEHAVIOURS),
) -> dict[str, float]:
    """`soak_violations`: cycles in which a robot was beyond a limit; `soak_stops`: runs that the guard ended.

    Each behaviour runs `seconds` simulated seconds on each pairing, touched by a hand with 1 to 15 N, but no harder
    than its joints bear, at one cell after the other, with pauses.
    """
    violations = stops = interventions = touches = 0
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
                session.world.push(cell, min(float(rng.uniform(*FORCE_N)), bearable_force(session, cell)))
                session.run(float(rng.uniform(*HELD_S)))
                session.world.release()
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
        "soak_s": simulated,
        "soak_behaviour_s": seconds,
    }
