# SPDX-License-Identifier: Apache-2.0
"""The largest pushes that a standing robot bears through firmware, network and driver, beside those of the reduced rig.

Cell, plate and push are those of the reduced rig, whose skin tells true forces some milliseconds late. A statue is
pushed there, too.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from contextlib import nullcontext, suppress

import numpy as np

from robotskin.layout import finished
from robotskin.robots.gains import robot_with_gains
from robotskin.session import SafetyState, Session
from robotskin.world import WorldError
from robotskin.world.things import FloorSpec, SceneSpec
from robotskin_lab.bench.balance_kinds import Kind, Way
from robotskin_lab.bench.balance_rig import (
    ROBOT,
    STATUE,
    StandingRig,
    drawn_cells,
    fallen,
    plate_before,
    push_with_plate,
)
from robotskin_lab.bench.balance_search import Outcome, largest_stood
from robotskin_lab.bench.progress import tell

SETTLES_S = 1.0


def chain_figures(seed: int, kinds: Sequence[Kind], reduced: Callable[[Kind, int, Way], float]) -> dict[str, float]:
    """Of one drawn cell for each direction: chain_FIGURE, the largest push found, the worse direction;
    chain_over_reduced_FIGURE: the least ratio to what the reduced rig finds at the same cell; statue_at_chain_FIGURE:
    the largest push that a statue stands there, the worse direction; chain_over_statue_FIGURE: the ratio of both;
    chain_FIGURE without its unit and with _stops: pushes that it stood though the guard stopped it.

    Args:
        seed: of world, cells and network.
        kinds: of push.
        reduced: the largest push that the reduced rig stands, by kind, cell and direction.
    """
    figures: dict[str, float] = {}
    for kind in kinds:
        sizes, ratios, statues, stops = [], [], [], 0
        for direction, link in kind.met.items():
            cell = drawn_cells(seed, 1, link, np.array(direction))[0]
            beside = reduced(kind, cell, direction)
            statues.append(statue_stands(seed, kind, cell, direction))

            def push(size: float, kind: Kind = kind, cell: int = cell, direction: Way = direction) -> Outcome:
                return pushed_through_chain(seed, cell, direction, *kind.profile(size))

            found = largest_stood(push, beside or kind.first, kind.most, 1, least=kind.first / 12)
            sizes.append(found.largest)
            ratios.append(found.largest / max(beside, 1e-9))
            stops += found.stops
            tell(
                f"balance: seed {seed}, {kind.figure} along {sum(direction):+.0f}: {found.largest:.1f} through the "
                f"chain, {beside:.1f} by the reduced rig, {statues[-1]:.1f} by a statue, {found.stops} stops"
            )
        figure = kind.figure
        name, _ = figure.rsplit("_", 1)
        figures[f"chain_{figure}"] = min(sizes)
        figures[f"chain_over_reduced_{figure}"] = min(ratios)
        figures[f"statue_at_chain_{figure}"] = min(statues)
        figures[f"chain_over_statue_{figure}"] = min(sizes) / max(min(statues), 1e-9)
        figures[f"chain_{name}_stops"] = float(stops)
    return figures


def statue_stands(seed: int, kind: Kind, cell: int, direction: Way) -> float:
    """Newton or newton seconds, the largest push found that a statue stands; 0 if it falls at the least."""

    def push(size: float) -> Outcome:
        return Outcome(StandingRig(ROBOT, STATUE, seed, cell, direction).push(*kind.profile(size)), stopped=False)

    return largest_stood(push, kind.first, kind.most, 1, least=kind.first / 12).largest


def pushed_through_chain(
    seed: int, cell: int, direction: Way, force_n: Callable[[float], float], seconds: float
) -> Outcome:
    """One push of the plate on a robot whose cells, network, section units and driver all run."""
    ready, layout, way = robot_with_gains(ROBOT), finished(ROBOT), np.array(direction)
    plate = plate_before(ready.robot, layout, ready.gains.home, cell, way)
    scene = SceneSpec(floor=FloorSpec(robot_stands=True), things=(plate,))
    session = Session(ready.robot, layout, seed=seed, gains=ready.gains, link="in process", scene=scene)
    home_height = float(ready.gains.home[2])
    stands = True
    try:
        session.boot()
        session.run(SETTLES_S)
        stands = push_with_plate(
            session.world.thing("plate"),
            way,
            force_n,
            seconds,
            step=session.step,
            fallen=lambda: fallen(session.world, home_height),
        )
        stopped = session.state not in (SafetyState.running, SafetyState.degraded)
    finally:
        # The plate may lie inside of a robot that has fallen; that it fell is known by then.
        with nullcontext() if stands else suppress(WorldError):
            session.shut_down()
    return Outcome(stands, stopped)
