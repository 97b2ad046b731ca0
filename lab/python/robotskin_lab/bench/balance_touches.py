# SPDX-License-Identifier: Apache-2.0
"""A standing robot that is touched at several places, and at random."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from robotskin.session import PERIOD_S
from robotskin.tasks import SelfCollisionGains
from robotskin_lab.bench.balance_cells import EMBRACE, borne_n, hand_cells
from robotskin_lab.bench.balance_drawn import PAUSE_S, drawn_touch, touched_links
from robotskin_lab.bench.balance_rig import CHEST, ROBOT, Law, StandingRig
from robotskin_lab.bench.progress import tell

TRIPLE_LINKS = (
    ("arm_left_4_link", "arm_left_2_link", "arm_left_3_link"),
    ("arm_right_7_link", "arm_right_5_link", "arm_right_4_link"),
    ("torso_2_link",),
)
"""One cell of each row: of an arm, of the other's wrist or forearm, of chest or back."""
TRIPLE_N, TRIPLE_S, REST_S = 25.0, 2.0, 1.0
LOOK_TICKS = 5
LOOKS_M = SelfCollisionGains().safe_m
"""Bodies that are farther apart are not looked at."""


def three_figures(seed: int, triples: int) -> dict[str, float]:
    """Three pushes of 25 N at once, drawn; how many triples the robot stands, and how far the points give way.

    three_stops: triples at which the guard stopped the robot; it is started again, and how its points gave is not
    counted. three_unfelt_points: that were pressed with less than half of the force, and do not count. Of the others,
    over the force on it, the least: three_give_mm_per_n along the push, three_arm_… and three_chest_… of those on
    links of these; three_way_mm_per_n in whatever direction.
    """
    draw = np.random.default_rng([seed, 3])
    stood = stops = unfelt = 0
    points: list[TriplePoint] = []
    rig: StandingRig | None = None
    for number in range(triples):
        cells = triple_cells(draw)
        if rig is None or rig.fallen:
            rig = StandingRig(ROBOT, Law("compliant"), seed, hands=3, worn=EMBRACE)
        found = pushed_at_once(rig, cells)
        pressed = [point for point in found if point.force_n > TRIPLE_N / 2]
        unfelt += len(found) - len(pressed)
        rig.world.release()
        rig.run(REST_S)
        stood += not rig.fallen
        tell(f"balance: seed {seed}, triple {number + 1}: {', '.join(map(str, found))}")
        if not rig.stopped:
            points += pressed
        elif not rig.fallen:
            assert rig.skinned is not None
            tell(f"balance: seed {seed}, triple {number + 1}: {rig.skinned.why_not_running()}")
            stops += 1
            rig.start_again()
    chest = [point for point in points if point.link == CHEST]
    arms = [point for point in points if point.link != CHEST]
    return {
        "three_share": stood / triples,
        "three_stops": float(stops),
        "three_unfelt_points": float(unfelt),
        "three_give_mm_per_n": min((point.give_mm_per_n for point in points), default=0.0),
        "three_arm_give_mm_per_n": min((point.give_mm_per_n for point in arms), default=0.0),
        "three_chest_give_mm_per_n": min((point.give_mm_per_n for point in chest), default=0.0),
        "three_way_mm_per_n": min((point.way_mm_per_n for point in points), default=0.0),
    }


@dataclass(frozen=True)
class TriplePoint:
    """A cell that is pushed: the force on it at the end, and how far it went along the push and in all, per newton."""

    link: str
    cell: int
    force_n: float
    give_mm_per_n: float
    way_mm_per_n: float

    def __str__(self) -> str:
        return f"{self.link} {self.cell} gives {self.give_mm_per_n:.2f} mm/N to {self.force_n:.0f} N"


def triple_cells(draw: np.random.Generator) -> list[int]:
    """A cell of each of `TRIPLE_LINKS`, of links that have some."""
    rows = [[link for link in row if len(hand_cells(link))] for row in TRIPLE_LINKS]
    return [int(draw.choice(hand_cells(str(draw.choice(row))))) for row in rows]


def pushed_at_once(rig: StandingRig, cells: list[int]) -> list[TriplePoint]:
    """Push cells against their normals, a hand each, and tell where they came to; the push goes on."""
    before = [rig.world.base_from_cell(cell).copy() for cell in cells]
    for hand, cell in enumerate(cells):
        rig.world.push(cell, TRIPLE_N, hand=hand)
    rig.run(TRIPLE_S)
    found = []
    for cell, at, force in zip(cells, before, rig.world.contact_normal_force()[: len(cells)], strict=True):
        way = 1e3 * (rig.cell_place(cell) - at[:3, 3])
        newton = max(float(force), 1e-9)
        link = rig.layout.links[rig.layout.link[cell]]
        found.append(
            TriplePoint(link, cell, float(force), -float(at[:3, 2] @ way) / newton, float(np.linalg.norm(way)) / newton)
        )
    return found


def touch_figures(seed: int, seconds: float) -> dict[str, float]:
    """Touches at random places of all but the legs: falls, cycles beyond a limit, how near bodies come.

    No touch is harder than what the motors bear there (`borne_n`).
    """
    draw = np.random.default_rng([seed, 10])
    rig = StandingRig(ROBOT, Law("compliant"), seed, hands=1, self_collision=True)
    links = touched_links(rig.layout)
    falls = stops = count = violations = 0
    elapsed, closest = 0.0, np.inf
    while elapsed < seconds:
        touch = drawn_touch(draw, links)
        force = min(touch.force_n, borne_n()[touch.cell])
        rig.world.push(touch.cell, force)
        # A hand needs time to come.
        for _ in range(1500):
            rig.step()
            if rig.world.contact_normal_force()[0] > force / 4:
                break
        closest = min(closest, closest_while(rig, touch.seconds))
        rig.world.release()
        closest = min(closest, closest_while(rig, touch.pause_s))
        count += 1
        elapsed = rig.time_s if falls == 0 else elapsed + touch.seconds + PAUSE_S[1]
        assert rig.skinned is not None
        if rig.stopped:
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
