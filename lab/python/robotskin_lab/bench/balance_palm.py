# SPDX-License-Identifier: Apache-2.0
"""A palm that comes near a standing robot, through firmware, network and driver, and stops where a cell was."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from robotskin.robots.gains import robot_with_gains
from robotskin.session import PERIOD_S, SafetyState, Session
from robotskin.world.things import Box, FloorSpec, PathSpec, SceneSpec, ThingSpec, WaypointSpec
from robotskin_lab.bench.balance_cells import EMBRACE, chest_cells, free_cells, worn_by_robot
from robotskin_lab.bench.balance_rig import LOWEST_SHARE, ROBOT
from robotskin_lab.bench.progress import tell

Array = NDArray[np.float64]
FOREARM = "arm_left_5_link"
PRESSED_N, DRAWS = 5.0, 4
"""What a palm presses a robot with that does not move, at least; else another cell is drawn, so often in all."""
SPEED_M_S, FROM_M = 0.1, 0.15
WIDTH_M, THICKNESS_M, FLESH_N_PER_M = 0.09, 0.02, 10_000.0
SETTLES_S, WAITS_S = 2.5, 1.0
AWAY_M = (0.0, 0.0, 4.0)


def palm_figures(seed: int) -> dict[str, float]:
    """The largest force of a palm that comes at 0.1 m/s to where a cell was, how far the cell draws back, and whether
    the robot stands; beside it the least of such forces on a robot that neither touch nor nearness moves.

    A cell at which the palm does not press that robot is drawn again: palm_redrawn.
    """
    found, stiff, redrawn = [], [], 0
    for name, cells in palm_cells().items():
        draw = np.random.default_rng([seed, 7])
        for number in range(DRAWS):
            cell = int(draw.choice(cells))
            pressed = palm_trial(seed, name, cell, feels=False)
            if pressed.force_n >= PRESSED_N:
                break
            redrawn += number < DRAWS - 1
        stiff.append(pressed)
        found.append(palm_trial(seed, name, cell, feels=True))
    return {
        "palm_force_n_max": max(one.force_n for one in found),
        "palm_way_mm": 1e3 * min(one.way_m for one in found),
        "palm_stands": float(all(one.stands for one in found)),
        "stiff_palm_force_n": min(one.force_n for one in stiff),
        "palm_redrawn": float(redrawn),
    }


def palm_cells() -> dict[str, NDArray[np.int64]]:
    """Of the layout `EMBRACE`, to which a palm comes, by what they are on: the forearm, and the chest's front."""
    return {"forearm": free_cells(FOREARM, EMBRACE), "chest": chest_cells()}


@dataclass(frozen=True)
class PalmTrial:
    """force_n: the largest of the palm. way_m: of the cell along its inward normal, when the palm has waited."""

    force_n: float
    way_m: float
    stands: bool


def palm_trial(seed: int, name: str, cell: int, *, feels: bool) -> PalmTrial:
    """A palm nears a cell, which is on what is named. feels: touch and nearness move the robot."""
    ready = robot_with_gains(ROBOT)
    palm_spec = ThingSpec(
        name="palm",
        shape=Box(lengths_m=(WIDTH_M, WIDTH_M, THICKNESS_M)),
        moves="path",
        path=PathSpec(waypoints=(WaypointSpec(at_s=0.0, position_m=AWAY_M),)),
        stiffness_n_per_m=FLESH_N_PER_M,
        gives="local",
    )
    scene = SceneSpec(floor=FloorSpec(robot_stands=True), things=(palm_spec,))
    session = Session(ready.robot, worn_by_robot(EMBRACE), seed=seed, gains=ready.gains, link="in process", scene=scene)
    try:
        session.boot()
        session.set_skin(feels)
        session.run(SETTLES_S)
        before = session.world.base_from_cell(cell)
        palm = session.world.thing("palm")
        palm.follow(way_to(before[:3, 3], before[:3, 2]))
        largest = 0.0
        for _ in range(round((FROM_M / SPEED_M_S + WAITS_S) / PERIOD_S)):
            session.step()
            largest = max(largest, palm.skin_force_n)
        inward = -before[:3, 2] @ (session.world.base_from_cell(cell)[:3, 3] - before[:3, 3])
        height = float(session.world.joint_positions()[2])
        stands = height > LOWEST_SHARE * session.home[2] and session.state in (
            SafetyState.running,
            SafetyState.degraded,
        )
    finally:
        session.shut_down()
    tell(
        f"balance: seed {seed}, palm to {name}, cell {cell}{'' if feels else ', skin off'}: {largest:.2f} N, "
        f"draws back {1e3 * inward:.0f} mm"
    )
    return PalmTrial(largest, float(inward), stands)


def way_to(place: Array, normal: Array) -> PathSpec:
    """Straight against a cell's normal (3), until the palm's face is at its place (3) m, both in the world."""
    x, y, z = (float(value) for value in normal)
    turn = (0.0, float(np.degrees(np.arccos(z))), float(np.degrees(np.arctan2(y, x))))

    def at(time_s: float, gap_m: float) -> WaypointSpec:
        a, b, c = (float(value) for value in place + (gap_m + THICKNESS_M / 2) * normal)
        return WaypointSpec(at_s=time_s, position_m=(a, b, c), rotation_deg=turn)

    return PathSpec(smooth=False, waypoints=(at(0.0, FROM_M), at(FROM_M / SPEED_M_S, 0.0)))
