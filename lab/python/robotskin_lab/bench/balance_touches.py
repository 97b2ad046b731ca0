# SPDX-License-Identifier: Apache-2.0
"""A standing robot that is touched at several places, and at random."""

from __future__ import annotations

import numpy as np

from robotskin.session import PERIOD_S, SafetyState
from robotskin.tasks import SelfCollisionGains
from robotskin_lab.bench.balance_cells import borne_n, inner_cells
from robotskin_lab.bench.balance_rig import ROBOT, Law, StandingRig
from robotskin_lab.bench.progress import tell

TRIPLE_LINKS = (
    ("arm_left_4_link", "arm_left_2_link", "arm_left_3_link"),
    ("arm_right_5_link", "arm_right_6_link", "arm_right_4_link"),
    ("torso_2_link",),
)
"""One cell of each row: of an arm, of the other's wrist or forearm, of chest or back."""
TRIPLE_N, TRIPLE_S, REST_S = 25.0, 2.0, 1.0
LARGEST_STEP_N = 40.0
TOUCH_S, PAUSE_S = (0.1, 1.2), (0.2, 1.0)
LARGEST_IMPULSE_NS = 10.0
"""Of touches that are shorter than `SHORT_S`."""
SHORT_S = 0.25
LOOK_TICKS = 5
LOOKS_M = SelfCollisionGains().safe_m
"""Bodies that are farther apart are not looked at."""


def three_figures(seed: int, triples: int) -> dict[str, float]:
    """Three pushes of 25 N at once, drawn; how many triples the robot stands, and how far the points give way."""
    draw = np.random.default_rng([seed, 3])
    stood, gives = 0, []
    rig: StandingRig | None = None
    for number in range(triples):
        rows = [[link for link in row if len(inner_cells(link))] for row in TRIPLE_LINKS]
        cells = [int(draw.choice(inner_cells(str(draw.choice(row))))) for row in rows]
        if rig is None or rig.fallen:
            rig = StandingRig(ROBOT, Law("compliant"), seed, hands=3)
        before = [rig.cell_place(cell) for cell in cells]
        for hand, cell in enumerate(cells):
            rig.world.push(cell, TRIPLE_N, hand=hand)
        rig.run(TRIPLE_S)
        force = rig.world.contact_normal_force()[:3]
        moved = [float(np.linalg.norm(rig.cell_place(cell) - at)) for cell, at in zip(cells, before, strict=True)]
        gives += [1e3 * way / TRIPLE_N for way, newton in zip(moved, force, strict=True) if newton > TRIPLE_N / 2]
        rig.world.release()
        rig.run(REST_S)
        stood += not rig.fallen
        tell(
            f"balance: seed {seed}, triple {number + 1}: {np.round(force)} N move {np.round(1e3 * np.array(moved))} mm"
        )
    return {"three_share": stood / triples, "three_give_mm_per_n": float(np.min(gives)) if gives else 0.0}


def touch_figures(seed: int, seconds: float) -> dict[str, float]:
    """Touches at random places of all but the legs: falls, commands beyond a limit, how near bodies come.

    No touch is harder than what the motors bear there (`borne_n`).
    """
    draw = np.random.default_rng([seed, 10])
    rig = StandingRig(ROBOT, Law("compliant"), seed, hands=1, self_collision=True)
    links = [link for link in rig.layout.links if "leg" not in link and len(inner_cells(link))]
    falls = stops = count = violations = 0
    elapsed, closest = 0.0, np.inf
    while elapsed < seconds:
        cell = int(draw.choice(inner_cells(str(draw.choice(links)))))
        lasts = float(draw.uniform(*TOUCH_S))
        force = min(float(draw.uniform(5.0, LARGEST_STEP_N)), borne_n()[cell])
        if lasts < SHORT_S:
            force = min(force, LARGEST_IMPULSE_NS / lasts)
        rig.world.push(cell, force)
        # A hand needs time to come.
        for _ in range(1500):
            rig.step()
            if rig.world.contact_normal_force()[0] > force / 4:
                break
        closest = min(closest, closest_while(rig, lasts))
        rig.world.release()
        closest = min(closest, closest_while(rig, float(draw.uniform(*PAUSE_S))))
        count += 1
        elapsed = rig.time_s if falls == 0 else elapsed + lasts + PAUSE_S[1]
        assert rig.skinned is not None
        if rig.skinned.state not in (SafetyState.running, SafetyState.degraded):
            stops += 1
            tell(f"balance: seed {seed}, touch {count}: {rig.skinned.why_not_running()}")
            rig.start_again()
        if rig.fallen:
            falls += 1
            violations += rig.skinned.controller.report.violations
            rig = StandingRig(ROBOT, Law("compliant"), seed, hands=1, self_collision=True)
    assert rig.skinned is not None
    tell(f"balance: seed {seed}, {count} touches, {falls} falls, {stops} stops")
    return {
        "touch_falls": float(falls),
        "touch_stops_max": float(stops),
        "touch_limit_violations": float(violations + rig.skinned.controller.report.violations),
        "touch_closest_mm": 1e3 * min(closest, LOOKS_M),
        "touches": float(count),
    }


def closest_while(rig: StandingRig, seconds: float) -> float:
    """Metres between the nearest two bodies of a robot that goes on; a fallen one tells nothing."""
    closest = np.inf
    for tick in range(round(seconds / PERIOD_S)):
        rig.step()
        if tick % LOOK_TICKS == 0 and not rig.fallen:
            closest = min(closest, rig.closest_m)
    return closest
