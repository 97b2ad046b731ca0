# SPDX-License-Identifier: Apache-2.0
"""`robotskin bench blows`: short blows at random places of a standing robot, its cells, network and driver running."""

from __future__ import annotations

import time
from dataclasses import dataclass
from typing import Annotated, Any

import numpy as np
import typer

from robotskin.session import PERIOD_S
from robotskin.session.touches import bearable_force, is_reached
from robotskin_lab.bench.balance_cells import inner_cells, worn_by_robot
from robotskin_lab.bench.balance_chain_touches import COMES_S, TouchedSession
from robotskin_lab.bench.balance_drawn import PAUSE_S, touched_links
from robotskin_lab.bench.balance_touches import LOOKS_M
from robotskin_lab.bench.progress import tell

IMPULSE_NS = (1.0, 10.0)
BLOW_S, AFTER_S = 0.1, 2.5
"""A half sine, and how long a robot is looked at after the last one, as in `robotskin bench balance`."""
TOUCH_N = 2.0
"""With which the hand lies on the cell before the blow."""
HAND_RISES_S = 0.1
"""From a touch to the force that a simulated hand is asked for (`core/world/hand.cpp`)."""
MISSED_SHARE = 0.5
"""Of the impulse that was asked for; a hand that brings less has missed."""
PARTS = ("trunk", "upper_arm", "forearm", "head")
FIRST_OF_FOREARM = 4
"""The number in the name of an arm's link, from which on it is the elbow or lies beyond it."""
TELL_BLOWS = 20


def run(
    *,
    seed: int = 1,
    seconds: Annotated[float, typer.Option(min=1.0)] = 60.0,
    borne_share: Annotated[float, typer.Option(min=0.0)] = 0.5,
) -> dict[str, Any]:
    """Blows of 1 to 10 N s, each a half sine of 0.1 s, against drawn cells of all links but the legs.

    A blow asks for `borne_share` of the torque of a joint between pelvis and cell at most, where the robot is as it
    begins, and is made lighter where it would ask for more. Cells that another part of the robot covers are drawn anew.

    blow_falls, blow_stops_max: of the guard, blow_limit_violations: cycles beyond a limit, blow_closest_mm: how near
    bodies came, at most 50, blow_s: time in all. blows: how many, blows_lighter: those made lighter, blows_from_4_ns:
    those that brought at least 4 N s, blows_missed: besides, those that brought less than half of what was asked for,
    blows_covered: draws left out. blow_median_ns, blow_largest_PART_ns: what the hand truly brought to trunk,
    upper_arm, forearm or head, 0 where none was struck. blow_peak_over_asked_max: the largest contact force of a blow
    over the top of the half sine.

    Args:
        seed: of world, cells and network.
        seconds: of blows.
        borne_share: of what the motors bear where the blow meets the robot, at most.
    """
    began = time.process_time()
    draw = np.random.default_rng([seed, 12])
    links = touched_links(worn_by_robot())
    falls = stops = violations = missed = covered = 0
    elapsed, closest_m = 0.0, float(LOOKS_M)
    blows: list[Blow] = []
    while elapsed < seconds:
        robot = TouchedSession(seed)
        began_s = robot.session.world.time_s
        try:
            while not robot.fallen and elapsed + robot.session.world.time_s - began_s < seconds:
                link = str(draw.choice(links))
                cell, asked_ns = int(draw.choice(inner_cells(link))), float(draw.uniform(*IMPULSE_NS))
                pause_s = float(draw.uniform(*PAUSE_S))
                if not is_reached(robot.session, cell):
                    covered += 1
                    continue
                blow = strike(robot, cell, part_of(link), peak_of(asked_ns), borne_share)
                if blow is None or blow.brought_ns < MISSED_SHARE * blow.asked_ns:
                    missed += 1
                else:
                    blows.append(blow)
                robot.run(pause_s)
                robot.start_if_stopped()
                if robot.fallen or len(blows) % TELL_BLOWS == 0:
                    now_s = elapsed + robot.session.world.time_s - began_s
                    state = "it has fallen" if robot.fallen else "it stands"
                    tell(f"blows: seed {seed}, {len(blows)} in {now_s:.0f} s, {state}")
            robot.run(AFTER_S)
            robot.start_if_stopped()
            falls += robot.fallen
            stops += robot.stops
            violations += robot.violations
            closest_m = min(closest_m, robot.closest_m)
            elapsed += robot.session.world.time_s - began_s
        finally:
            robot.end()
    tell("")
    brought_ns = [blow.brought_ns for blow in blows]
    largest = {part: max((blow.brought_ns for blow in blows if blow.part == part), default=0.0) for part in PARTS}
    return {
        "blow_falls": float(falls),
        "blow_stops_max": float(stops),
        "blow_limit_violations": float(violations),
        "blow_closest_mm": 1e3 * closest_m,
        "blow_s": elapsed,
        "blows": float(len(blows)),
        "blows_lighter": float(sum(blow.lighter for blow in blows)),
        "blows_from_4_ns": float(sum(one >= 4.0 for one in brought_ns)),
        "blows_missed": float(missed),
        "blows_covered": float(covered),
        "blow_median_ns": float(np.median(brought_ns)) if brought_ns else 0.0,
        **{f"blow_largest_{part}_ns": size for part, size in largest.items()},
        "blow_peak_over_asked_max": max((blow.peak_over_asked for blow in blows), default=0.0),
        "processor_s": time.process_time() - began,
    }


def part_of(link: str) -> str:
    """Which of `PARTS` a link belongs to."""
    if link.startswith("head"):
        return "head"
    if not link.startswith("arm"):
        return "trunk"
    return "forearm" if int(link.split("_")[2]) >= FIRST_OF_FOREARM else "upper_arm"


@dataclass(frozen=True)
class Blow:
    """One blow: what was asked for, what the hand brought (N s), and its largest force over the top of the half sine.

    lighter: than drawn, for the sake of a motor.
    """

    part: str
    asked_ns: float
    brought_ns: float
    peak_over_asked: float
    lighter: bool


def peak_of(impulse_ns: float) -> float:
    """Newton, the top of a half sine of `BLOW_S` that carries so much."""
    return impulse_ns * np.pi / (2 * BLOW_S)


def strike(robot: TouchedSession, cell: int, part: str, peak_n: float, borne_share: float = 1e9) -> Blow | None:
    """A hand comes, lies on a cell, strikes it with a half sine of so many newton, and leaves.

    None: the hand did not come to the cell.
    """
    session = robot.session
    session.world.push(cell, TOUCH_N)
    for _ in range(round(COMES_S / PERIOD_S)):
        robot.run(PERIOD_S)
        if session.world.contact_normal_force()[0] > TOUCH_N / 2 or robot.fallen:
            break
    else:
        session.world.release()
        return None
    bearable_n = bearable_force(session, cell, borne_share)
    top_n, before_n, forces_n = min(peak_n, bearable_n), TOUCH_N, [0.0]
    for tick in range(round(BLOW_S / PERIOD_S)):
        if robot.fallen:
            break
        force_n = max(TOUCH_N, top_n * float(np.sin(np.pi * tick * PERIOD_S / BLOW_S)))
        # A hand takes `HAND_RISES_S` to what it is asked for, so it is asked for what brings it there in one period.
        session.world.push(cell, max(force_n, (force_n - before_n) * HAND_RISES_S / PERIOD_S))
        before_n = force_n
        robot.run(PERIOD_S)
        forces_n.append(float(session.world.contact_normal_force()[0]))
    session.world.release()
    return Blow(
        part,
        top_n * 2 * BLOW_S / np.pi,
        PERIOD_S * sum(forces_n),
        max(forces_n) / max(top_n, TOUCH_N),
        bearable_n < peak_n,
    )
