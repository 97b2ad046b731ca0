# SPDX-License-Identifier: Apache-2.0
"""`robotskin bench control`, endurance: every behaviour under random touches, on the paper's three pairings."""

from __future__ import annotations

import numpy as np

from robotskin.control import BEHAVIOURS
from robotskin_lab.bench.control_rig import PERIOD_S, ControlRig
from robotskin_lab.bench.progress import tell

PAIRINGS = (("allegro_right_hand", "torque"), ("dual_arm", "velocity"), ("talos", "position"))
"""Robot and interface (V-A, V-B, V-D)."""


def soak_figures(seed: int, seconds: float) -> dict[str, float]:
    """`soak_violations`: cycles in which a robot was beyond a limit; `soak_stops`: runs that the guard ended.

    Each behaviour runs `seconds` simulated seconds on each pairing, touched by frictionless pushes of 1 to 15 N (5 N on
    the hand's fingers), one after the other, with pauses.
    """
    violations = stops = interventions = 0
    simulated = 0.0
    for robot, interface in PAIRINGS:
        for index, behaviour in enumerate(BEHAVIOURS):
            rig = ControlRig(robot, behaviour, interface, seed, hands=0)
            rng = np.random.default_rng([seed, index])
            most = 5.0 if robot.startswith("allegro") else 15.0
            ticks = round(seconds / PERIOD_S)
            while ticks > 0:
                rig.push(int(rng.integers(len(rig.layout))), float(rng.uniform(1.0, most)))
                held = min(ticks, int(rng.integers(300, 1500)))
                rig.run(held * PERIOD_S)
                rig.push(0, 0.0)
                rest = min(ticks - held, int(rng.integers(100, 800)))
                rig.run(rest * PERIOD_S)
                ticks -= held + rest
            report = rig.controller.report
            end = "running" if rig.running else f"stopped: {report.text}"
            tell(f"soak: {robot}, {behaviour}: {seconds:.0f} s, {report.violations} violations, {end}")
            violations += report.violations
            interventions += report.interventions
            stops += not rig.running
            simulated += seconds
    tell("")
    return {
        "soak_violations": float(violations),
        "soak_stops": float(stops),
        "soak_interventions": float(interventions),
        "soak_s": simulated,
        "soak_behaviour_s": seconds,
    }
