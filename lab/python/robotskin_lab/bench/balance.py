# SPDX-License-Identifier: Apache-2.0
"""`robotskin bench balance`: how hard a standing robot may be pushed, and how far it gives way."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np

from robotskin import robots
from robotskin.errors import UnknownNameError
from robotskin.layout import finished
from robotskin.robots.gains import GainSet
from robotskin.tasks import BalanceGains
from robotskin_lab.bench.balance_rig import STATUE, Law, StandingRig, impulse, ramp, step
from robotskin_lab.bench.progress import tell

ROBOT, CHEST = "talos_standing", "torso_2_link"
Profile = tuple[Callable[[float], float], float]


def _without_skin(gains: BalanceGains) -> None:
    gains.by_skin = False


def _without_feet(gains: BalanceGains) -> None:
    gains.by_feet = False


LAWS = {
    "": Law("compliant"),
    "stiff": Law("stiff", skin=False),
    "statue": STATUE,
    "unbalanced": Law("unbalanced", balance=False),
    "skinless": Law("skinless", skin=False, change=_without_skin),
    "footless": Law("footless", change=_without_feet),
}
"""By what stands before a figure's name. "" is the robot as it is; stiff: touch moves no joint, balance still feels it;
statue: joints held, its centre of mass truly centred; unbalanced: the skin without the task of balance; skinless:
balance by the feet alone; footless: by the skin and the inertial unit alone."""


@dataclass(frozen=True)
class Kind:
    """A kind of push: its figure, how it goes, between which sizes its limit is looked for, and along which axis."""

    figure: str
    profile: Callable[[float], Profile]
    least: float
    most: float
    side: bool = False


KINDS = (
    Kind("ramp_chest_n", ramp, 15.0, 165.0),
    Kind("step_chest_n", step, 15.0, 115.0),
    Kind("impulse_chest_ns", impulse, 4.0, 44.0),
    Kind("impulse_side_ns", impulse, 4.0, 60.0, side=True),
)
PARTS = ("limits", "give")
GIVE_N = (10.0, 20.0)
GIVE_LINKS = ("arm_left_6_link", "arm_right_6_link", "arm_left_4_link", "arm_right_4_link", "arm_left_3_link")


def run(
    *,
    seed: int = 1,
    seeds: int = 1,
    cells: int = 1,
    halvings: int = 4,
    laws: str = "all",
    kinds: str = "all",
    parts: str = "limits,give",
) -> dict[str, Any]:
    """Pushes of a padded plate about drawn cells of the chest, until the robot falls; the worse of both directions.

    Physics, port, estimate, tasks, guard and imperfections are all there. The cells' network is not: the skin's forces
    are true, 8 ms late, and end at 10 N a sensor.

    Args:
        seed: of world and cells; the first of `seeds`.
        seeds: how many are run; the worst counts.
        cells: drawn for each direction; their median counts.
        halvings: of the interval in which a limit is looked for.
        laws: with commas between, of compliant, stiff, statue, unbalanced, skinless, footless; or all.
        kinds: figures, with commas between; or all.
        parts: with commas between: limits, give.

    Raises:
        UnknownNameError: no such law, kind or part.
    """
    for part in parts.split(","):
        if part not in PARTS:
            raise UnknownNameError("part", part, PARTS)
    wanted = [_named(name, LAWS) for name in LAWS] if laws == "all" else laws.split(",")
    chosen = [kind.figure for kind in KINDS] if kinds == "all" else kinds.split(",")
    for name in wanted:
        if name not in [_named(one, LAWS) for one in LAWS]:
            raise UnknownNameError("law", name, [_named(one, LAWS) for one in LAWS])
    for name in chosen:
        if name not in [kind.figure for kind in KINDS]:
            raise UnknownNameError("kind of push", name, [kind.figure for kind in KINDS])
    figures: dict[str, Any] = {}
    for one in range(seed, seed + seeds):
        found: dict[str, float] = {}
        if "limits" in parts.split(","):
            found |= limit_figures(one, cells, halvings, wanted, chosen)
        if "give" in parts.split(","):
            found |= give_figures(one, cells)
        for name, value in found.items():
            worse = max if name.endswith(("spread", "max")) or name.startswith("statue") else min
            figures[name] = worse(figures.get(name, value), value)
    for kind in KINDS:
        if {kind.figure, f"stiff_{kind.figure}"} <= figures.keys():
            figures[f"compliance_cost_{kind.figure}"] = figures[kind.figure] / max(
                figures[f"stiff_{kind.figure}"], 1e-9
            )
        if {kind.figure, f"statue_{kind.figure}"} <= figures.keys():
            figures[f"{kind.figure}_over_statue"] = figures[kind.figure] / max(figures[f"statue_{kind.figure}"], 1e-9)
    costs = [value for name, value in figures.items() if name.startswith("compliance_cost_")]
    if costs:
        figures["compliance_cost"] = min(costs)
    tell("")
    return figures | {"seeds": seeds, "cells": cells}


def _named(prefix: str, laws: dict[str, Law]) -> str:
    return laws[prefix].name


def drawn_cells(seed: int, count: int, link: str, direction: np.ndarray) -> list[int]:
    """Cells of a link that face a push in this direction (3,), inside of their patch, drawn."""
    robot, layout = robots.load(ROBOT), finished(ROBOT)
    places = robot.base_from_link(GainSet.load(ROBOT).home)
    index = [robot.link_index(name) for name in layout.links]
    outward = np.einsum("cij,cj->ci", places[np.array(index)[layout.link]][:, :3, :3], layout.link_from_cell[:, :3, 2])
    on_link = layout.link == layout.links.index(link)
    faces = on_link & (outward @ direction < -0.8)
    if not faces.any():
        faces = on_link & (outward @ direction <= (outward @ direction)[on_link].min() + 0.1)
    rng = np.random.default_rng([seed, *(np.abs(direction) * 2 + direction + 3).astype(int)])
    return [int(cell) for cell in rng.choice(np.flatnonzero(faces), count)]


def limit_figures(seed: int, cells: int, halvings: int, laws: list[str], kinds: list[str]) -> dict[str, float]:
    """The largest push that each law stands, of each kind."""
    figures: dict[str, float] = {}
    for kind in KINDS:
        if kind.figure not in kinds:
            continue
        for prefix, law in LAWS.items():
            if law.name not in laws:
                continue
            worst = np.inf
            for sign in (1.0, -1.0):
                direction = (0.0, sign, 0.0) if kind.side else (sign, 0.0, 0.0)
                drawn = drawn_cells(seed, cells, CHEST, np.array(direction))
                found = [largest_stood(law, kind, seed, cell, direction, halvings) for cell in drawn]
                tell(f"balance: seed {seed}, {law.name}, {kind.figure} along {sign:+.0f}: {np.round(found, 1)}")
                worst = min(worst, float(np.median(found)))
            figures["_".join(filter(None, (prefix, kind.figure)))] = worst
    return figures


def largest_stood(
    law: Law, kind: Kind, seed: int, cell: int, direction: tuple[float, float, float], halvings: int
) -> float:
    """Newton or newton seconds, the largest push found that the robot stands; 0 if it falls at the least."""
    low, high = 0.0, kind.most
    middle = kind.most / 2
    for _ in range(halvings):
        force, seconds = kind.profile(middle)
        stands = StandingRig(ROBOT, law, seed, cell, direction).push(force, seconds)
        low, high = (middle, high) if stands else (low, middle)
        middle = (low + high) / 2
    return low


def give_figures(seed: int, cells: int) -> dict[str, float]:
    """How far wrist and forearm give way to a newton along x, and how much the centre of mass moves."""
    gives, moved = [], []
    for link in GIVE_LINKS[: 2 * cells]:
        if link not in finished(ROBOT).links:
            continue
        direction = (-1.0, 0.0, 0.0)
        cell = drawn_cells(seed, 1, link, np.array(direction))[0]
        rig = StandingRig(ROBOT, LAWS[""], seed, cell, direction)
        plate = rig.world.thing("plate")
        places = []
        for force in (2.0, *GIVE_N):
            plate.push(force * rig.direction)
            rig.run(3.0)
            places.append((rig.cell_place(cell), rig.centre_of_mass()))
        for force, (cell_at, com_at) in zip(GIVE_N, places[1:], strict=True):
            gives.append(1e3 * float(np.linalg.norm(cell_at - places[0][0])) / (force - 2.0))
            moved.append(1e3 * float(np.linalg.norm((com_at - places[0][1])[:2])))
        tell(f"balance: seed {seed}, {link}: {np.round(gives[-2:], 2)} mm/N")
    return {
        "give_mm_per_n": float(np.median(gives)),
        "give_mm_per_n_spread": float(np.max(np.abs(np.array(gives) / np.median(gives) - 1))),
        "give_com_mm_max": float(np.max(moved)),
    }
