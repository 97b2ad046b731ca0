# SPDX-License-Identifier: Apache-2.0
"""`robotskin bench blows`: short blows at random places of a standing robot, its cells, network and driver running."""

from __future__ import annotations

import time
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
BLOW_S = 0.1
"""A half sine, as the blows of `robotskin bench balance`."""
TOUCH_N = 2.0
"""With which the hand lies on the cell before the blow."""
HAND_RISES_S = 0.1
"""From a touch to the force that a simulated hand is asked for (`core/world/hand.cpp`)."""
TELL_BLOWS = 20


def run(
    *,
    seed: int = 1,
    seconds: Annotated[float, typer.Option(min=1.0)] = 60.0,
    borne_share: Annotated[float, typer.Option(min=0.0)] = 0.5,
) -> dict[str, Any]:
    """Blows of 1 to 10 N s, each a half sine of 0.1 s, against drawn cells of all links but the legs.

    A blow asks for `borne_share` of a joint's torque at most, where the robot is by then, and is made lighter where it
    would ask for more. Cells that another part of the robot covers are drawn anew.

    blow_falls, blow_stops_max: of the guard, blow_limit_violations: cycles beyond a limit, blow_closest_mm: how near
    bodies came, at most 50, blow_s: time in all. blows: how many, blows_lighter: those made lighter, blows_from_4_ns:
    those that brought at least 4 N s, blows_covered: draws left out. blow_largest_ns, blow_median_ns: what the hand
    truly brought to the robot.

    Args:
        seed: of world, cells and network.
        seconds: of blows.
        borne_share: of what the motors bear where the blow falls, at most.
    """
    began = time.process_time()
    draw = np.random.default_rng([seed, 12])
    links = touched_links(worn_by_robot())
    falls = stops = violations = lighter = covered = 0
    elapsed, closest_m, brought_ns = 0.0, float(LOOKS_M), []
    while elapsed < seconds:
        robot = TouchedSession(seed)
        began_s = robot.session.world.time_s
        try:
            while not robot.fallen and elapsed + robot.session.world.time_s - began_s < seconds:
                cell = int(draw.choice(inner_cells(str(draw.choice(links)))))
                peak_n, pause_s = peak_of(float(draw.uniform(*IMPULSE_NS))), float(draw.uniform(*PAUSE_S))
                if not is_reached(robot.session, cell):
                    covered += 1
                    continue
                bearable_n = bearable_force(robot.session, cell, borne_share)
                lighter += bearable_n < peak_n
                brought_ns.append(strike(robot, cell, min(peak_n, bearable_n)))
                robot.run(pause_s)
                robot.start_if_stopped()
                if robot.fallen or len(brought_ns) % TELL_BLOWS == 0:
                    now_s = elapsed + robot.session.world.time_s - began_s
                    state = "it has fallen" if robot.fallen else "it stands"
                    tell(f"blows: seed {seed}, {len(brought_ns)} in {now_s:.0f} s, {state}")
            falls += robot.fallen
            stops += robot.stops
            violations += robot.violations
            closest_m = min(closest_m, robot.closest_m)
            elapsed += robot.session.world.time_s - began_s
        finally:
            robot.end()
    tell("")
    return {
        "blow_falls": float(falls),
        "blow_stops_max": float(stops),
        "blow_limit_violations": float(violations),
        "blow_closest_mm": 1e3 * closest_m,
        "blow_s": elapsed,
        "blows": float(len(brought_ns)),
        "blows_lighter": float(lighter),
        "blows_from_4_ns": float(sum(one >= 4.0 for one in brought_ns)),
        "blows_covered": float(covered),
        "blow_largest_ns": float(np.max(brought_ns, initial=0.0)),
        "blow_median_ns": float(np.median(brought_ns)) if brought_ns else 0.0,
        "processor_s": time.process_time() - began,
    }


def peak_of(impulse_ns: float) -> float:
    """Newton, the top of a half sine of `BLOW_S` that carries so much."""
    return impulse_ns * np.pi / (2 * BLOW_S)


def strike(robot: TouchedSession, cell: int, peak_n: float) -> float:
    """A hand comes, lies on the cell, strikes it and leaves; N s that it brought since it began to strike."""
    session, brought_ns, before_n = robot.session, 0.0, TOUCH_N
    session.world.push(cell, TOUCH_N)
    for _ in range(round(COMES_S / PERIOD_S)):
        session.step()
        if session.world.contact_normal_force()[0] > TOUCH_N / 2:
            break
    for tick in range(round(BLOW_S / PERIOD_S)):
        force_n = max(TOUCH_N, peak_n * float(np.sin(np.pi * tick * PERIOD_S / BLOW_S)))
        # A hand takes `HAND_RISES_S` to what it is asked for, so it is asked for what brings it there in one period.
        session.world.push(cell, max(force_n, (force_n - before_n) * HAND_RISES_S / PERIOD_S))
        before_n = force_n
        session.step()
        brought_ns += PERIOD_S * float(session.world.contact_normal_force()[0])
        if robot.fallen:
            break
    session.world.release()
    return brought_ns
