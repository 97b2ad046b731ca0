# SPDX-License-Identifier: Apache-2.0
"""`robotskin bench balance`: how hard a standing robot may be pushed, and how far it gives way."""

from __future__ import annotations

import time
from pathlib import Path
from typing import Annotated, Any

import numpy as np
import typer

from robotskin.apps.balance.insole import SHARE
from robotskin.errors import UnknownNameError
from robotskin.tasks import BalanceGains
from robotskin_lab.bench.balance_cells import EMBRACE, hand_cells
from robotskin_lab.bench.balance_chain import chain_figures
from robotskin_lab.bench.balance_chain_touches import chain_touch_figures
from robotskin_lab.bench.balance_faults import fault_figures
from robotskin_lab.bench.balance_kinds import KINDS, Kind
from robotskin_lab.bench.balance_palm import palm_figures
from robotskin_lab.bench.balance_picture import draw_pushed, pushed
from robotskin_lab.bench.balance_rig import CHEST, ROBOT, STATUE, Law, StandingRig, drawn_cells, ramp
from robotskin_lab.bench.balance_search import Found, Outcome, largest_stood
from robotskin_lab.bench.balance_soles import ComparedSolePort
from robotskin_lab.bench.balance_touches import three_figures, touch_figures
from robotskin_lab.bench.count import Count
from robotskin_lab.bench.progress import tell


def _without_skin(gains: BalanceGains) -> None:
    gains.by_skin = False


def _without_feet(gains: BalanceGains) -> None:
    gains.by_feet = False


def _without_shift(gains: BalanceGains) -> None:
    """The centre of mass is told to stay where it is, whatever pushes."""
    gains.by_skin = gains.by_feet = False


LAWS = {
    "": Law("compliant"),
    "stiff": Law("stiff", skin=False),
    "statue": STATUE,
    "unbalanced": Law("unbalanced", balance=False),
    "skinless": Law("skinless", skin=False, change=_without_skin),
    "footless": Law("footless", change=_without_feet),
    "soles": Law("soles", sole_cells=7),
}
"""By what stands before a figure's name. "" is the robot as it is; stiff: touch moves no joint, balance still feels it;
statue: joints held, its centre of mass truly centred; unbalanced: the skin without the task of balance; skinless:
balance by the feet alone; footless: by the skin and the inertial unit alone; soles: by those and seven cells a sole."""


PARTS = ("limits", "chain", "give", "three", "touches", "chain_touches", "palm", "soles", "faults")
LARGE_IS_WORSE = ("spread", "max", "falls", "stops", "unfelt_points", "redrawn", "violations", "error_p95_mm")
MOST_COUNTS = ("statue", "stiff_ramp", "stiff_step", "stiff_impulse", "fault_stops")
"""What names of figures begin with, of which the largest of the seeds counts."""
DRAWS_OF_EACH = 20
"""Draws for one cell that is asked for, so that nearly all that can be drawn are."""
TILED_CELLS = 32
SWAY_N = 60.0
TOUCH_N, GIVE_N, GIVE_S = 2.0, (10.0, 20.0), 3.0
WRISTS, FOREARMS = ("arm_left_7_link", "arm_right_7_link"), ("arm_left_5_link", "arm_right_5_link")
"""Links; the wrists have skin in the layout `EMBRACE` alone."""


def run(
    *,
    seed: int = 1,
    seeds: Count = 1,
    cells: Count = 1,
    halvings: Annotated[int, typer.Option(min=0)] = 1,
    laws: str = "all",
    kinds: str = "all",
    parts: str = "limits,give",
    triples: Count = 5,
    touches_s: Annotated[float, typer.Option(min=1.0)] = 60.0,
    picture: Path | None = None,
) -> dict[str, Any]:
    """Pushes of a padded plate about drawn cells of the chest, until the robot falls; the worse of both directions.

    A push from the side is on the shoulder, since the arms hang there.

    Physics, port, estimate, tasks, guard and imperfections are all there. The cells' network is there in the parts
    chain, chain_touches and palm; in all others the skin's forces are true, 8 ms late, and end at 10 N a sensor. Give,
    palm and three pushes at once are measured on the layout talos_embrace, in which chest and wrists have cells; all
    else on Talos' own.

    Args:
        seed: of world and cells; the first of `seeds`.
        seeds: how many are run; the worst counts.
        cells: drawn for each direction, each once; their median counts. Fewer where fewer face the push.
        halvings: of the last interval of 15 % in which a limit is looked for.
        laws: with commas between, of compliant, stiff, statue, unbalanced, skinless, footless, soles; or all.
        kinds: figures, with commas between; or all.
        parts: with commas between: limits, chain (limits at one cell, through firmware, network and
            driver), give, three (pushes at once), touches (at random), chain_touches (the same through firmware,
            network and driver), palm, soles (how far their zero-moment point is off), faults (of sensors, cells and
            control, one at a time); empty: none.
        triples: of pushes at once.
        touches_s: seconds of random touches.
        picture: where one slow push on the chest of a compliant robot and of a statue is drawn (PNG).

    Raises:
        UnknownNameError: no such law, kind or part.
    """
    began = time.process_time()
    asked = _names(parts)
    for part in asked:
        if part not in PARTS:
            raise UnknownNameError("part", part, PARTS)
    wanted = [law.name for law in LAWS.values()] if laws == "all" else _names(laws)
    chosen = [kind.figure for kind in KINDS] if kinds == "all" else _names(kinds)
    for name in wanted:
        if name not in [law.name for law in LAWS.values()]:
            raise UnknownNameError("law", name, [law.name for law in LAWS.values()])
    for name in chosen:
        if name not in [kind.figure for kind in KINDS]:
            raise UnknownNameError("kind of push", name, [kind.figure for kind in KINDS])
    each: list[dict[str, float]] = []
    for one in range(seed, seed + seeds):
        found: dict[str, float] = {}
        if "limits" in asked:
            found |= limit_figures(one, cells, halvings, wanted, chosen)
        if "chain" in asked:
            found |= through_chain(one, chosen)
        if "give" in asked:
            found |= give_figures(one, cells)
        if "three" in asked:
            found |= three_figures(one, triples)
        if "touches" in asked:
            found |= touch_figures(one, touches_s)
        if "chain_touches" in asked:
            found |= chain_touch_figures(one, touches_s)
        if "palm" in asked:
            found |= palm_figures(one)
        if "soles" in asked:
            found |= sole_figures(one)
        if "faults" in asked:
            found |= fault_figures(one)
        each.append(found | _ratios(found))
    figures: dict[str, Any] = {}
    for name in each[0]:
        values = [found[name] for found in each if name in found]
        most = name.endswith(LARGE_IS_WORSE) or name.startswith(MOST_COUNTS)
        figures[name] = max(values) if most else min(values)
    if picture is not None:
        draw_pushed(picture, {law.name: pushed(law, seed) for law in (LAWS[""], STATUE)})
    tell("")
    return figures | {"seeds": seeds, "cells": cells, "processor_s": time.process_time() - began}


def _names(told: str) -> list[str]:
    return [name.strip() for name in told.split(",") if name.strip()]


def _ratios(figures: dict[str, float]) -> dict[str, float]:
    """Of one seed, between laws."""
    found = {}
    for kind in KINDS:
        if {kind.figure, f"stiff_{kind.figure}"} <= figures.keys():
            found[f"compliance_cost_{kind.figure}"] = figures[kind.figure] / max(figures[f"stiff_{kind.figure}"], 1e-9)
        if {kind.figure, f"statue_{kind.figure}"} <= figures.keys():
            found[f"{kind.figure}_over_statue"] = figures[kind.figure] / max(figures[f"statue_{kind.figure}"], 1e-9)
    if {"ramp_chest_n", "soles_ramp_chest_n"} <= figures.keys():
        found["soles_over_ankles"] = figures["soles_ramp_chest_n"] / max(figures["ramp_chest_n"], 1e-9)
    if found and any(name.startswith("compliance_cost") for name in found):
        found["compliance_cost"] = min(value for name, value in found.items() if name.startswith("compliance_cost"))
    return found


def limit_figures(seed: int, cells: int, halvings: int, laws: list[str], kinds: list[str]) -> dict[str, float]:
    """The largest push that each law stands, of each kind: that the robot does not fall, stopped by the guard or not.

    …_stops: pushes that it stood though the guard stopped it. …_running_…: the largest tried that it stood running.
    """
    figures: dict[str, float] = {}
    for kind in KINDS:
        if kind.figure not in kinds:
            continue
        for prefix, law in LAWS.items():
            if law.name not in laws:
                continue
            worst = running = np.inf
            stops = 0
            for direction, link in kind.met.items():
                found: list[Found] = []
                for cell in different_cells(seed, cells, link, np.array(direction)):
                    before = found[-1].largest if found else None
                    found.append(largest_push(law, kind, seed, cell, direction, halvings, before))
                sizes = [one.largest for one in found]
                stops += sum(one.stops for one in found)
                tell(
                    f"balance: seed {seed}, {law.name}, {kind.figure} along {sum(direction):+.0f}: "
                    f"{np.round(sizes, 1)}, {stops} stops"
                )
                worst = min(worst, float(np.median(sizes)))
                running = min(running, float(np.median([one.running for one in found])))
            figures["_".join(filter(None, (prefix, kind.figure)))] = worst
            name, unit = kind.figure.rsplit("_", 1)
            figures["_".join(filter(None, (prefix, name, "stops")))] = float(stops)
            figures["_".join(filter(None, (prefix, name, "running", unit)))] = running
    return figures


def different_cells(seed: int, count: int, link: str, direction: np.ndarray) -> list[int]:
    """So many cells of a link that face a push in this direction (3,), each once; fewer where fewer face it."""
    drawn = drawn_cells(seed, DRAWS_OF_EACH * count, link, direction)
    return list(dict.fromkeys(drawn))[:count]


def largest_push(
    law: Law,
    kind: Kind,
    seed: int,
    cell: int,
    direction: tuple[float, float, float],
    halvings: int,
    first: float | None = None,
) -> Found:
    """Newton or newton seconds, the largest push found that the robot stands; 0 if it falls at the least.

    `first`: where to begin, such as what stood at another cell; by default the kind's own.
    """

    def push(size: float) -> Outcome:
        force, seconds = kind.profile(size)
        rig = StandingRig(ROBOT, law, seed, cell, direction)
        stands = rig.push(force, seconds)
        return Outcome(stands, rig.stopped)

    return largest_stood(push, first or kind.first, kind.most, halvings, least=kind.first / 12)


def through_chain(seed: int, kinds: list[str]) -> dict[str, float]:
    """The largest pushes through firmware, network and driver, at one cell, beside the reduced rig's."""
    return chain_figures(
        seed,
        [kind for kind in KINDS if kind.figure in kinds],
        lambda kind, cell, way: largest_push(LAWS[""], kind, seed, cell, way, 1).largest,
    )


def sole_figures(seed: int) -> dict[str, float]:
    """How far the zero-moment point of the soles' cells is off, 95 % of the time, while slow pushes sway the robot.

    linear_…: by a linear map of the same cells, at the same moments.
    sole_load_share: of a foot's load, what its cells carry.
    """
    figures = {"sole_load_share": SHARE}
    for name, cells in (("zmp", LAWS["soles"].sole_cells), ("tiled_zmp", TILED_CELLS)):
        errors: dict[str, list[float]] = {"": [], "linear_": []}
        for sign in (1.0, -1.0):
            direction = (sign, 0.0, 0.0)
            cell = drawn_cells(seed, 1, CHEST, np.array(direction))[0]
            rig = StandingRig(ROBOT, Law("soles", sole_cells=cells), seed, cell, direction)
            rig.push(*ramp(SWAY_N))
            assert isinstance(rig.port, ComparedSolePort)
            errors[""] += rig.port.errors_m
            errors["linear_"] += rig.port.linear_errors_m
        for map_name, found in errors.items():
            figures[f"{map_name}{name}_error_p95_mm"] = 1e3 * float(np.percentile(found, 95))
        tell(f"balance: seed {seed}, {cells} cells a sole: off by {figures[f'{name}_error_p95_mm']:.1f} mm")
    return figures


def give_figures(seed: int, cells: int) -> dict[str, float]:
    """How far cells of wrist and forearm give way to a newton of a ball, and how far touch alone moves the mass.

    A ball and no plate: a plate is as wide as the forearm is long, and lies across whatever stands beside the cell.
    """
    gives, moved = [], []
    for cell, wrist in give_cells(seed, cells):
        places, forces = pushed_by_ball(StandingRig(ROBOT, LAWS[""], seed, hands=1, worn=EMBRACE), cell)
        ways = 1e3 * np.linalg.norm(places[1:, :3] - places[0, :3], axis=1)
        gives += list(ways / (forces[1:] - forces[0]))
        tell(f"balance: seed {seed}, {'wrist' if wrist else 'forearm'}, cell {cell}: {np.round(gives[-2:], 2)} mm/N")
        if wrist:
            rig = StandingRig(ROBOT, Law("unshifted", change=_without_shift), seed, hands=1, worn=EMBRACE)
            places, _ = pushed_by_ball(rig, cell)
            moved.append(1e3 * float(np.linalg.norm(places[-1, 3:5] - places[0, 3:5])))
            tell(f"balance: seed {seed}, touch alone moves the centre of mass by {moved[-1]:.1f} mm")
    return {
        "give_mm_per_n": float(np.median(gives)),
        "give_least_mm_per_n": float(np.min(gives)),
        "give_mm_per_n_spread": float(np.max(np.abs(np.array(gives) / np.median(gives) - 1))),
        "give_com_mm_max": float(np.max(moved)),
    }


def give_cells(seed: int, count: int) -> list[tuple[int, bool]]:
    """So many cells of the wrist and of the forearm, of drawn arms; of each, whether it is the wrist's.

    They are those of the layout `EMBRACE`.
    """
    draw = np.random.default_rng([seed, 5])
    found = []
    for links in (WRISTS, FOREARMS):
        found += [(int(draw.choice(hand_cells(str(draw.choice(links))))), links is WRISTS) for _ in range(count)]
    return found


def pushed_by_ball(rig: StandingRig, cell: int, seconds: float = GIVE_S) -> tuple[np.ndarray, np.ndarray]:
    """Push a cell harder and harder, with each force so many seconds: until all is at rest.

    Returns:
        (K, 6) m, where the cell and the centre of mass came to be, and (K) N, with what force; the first is a touch.
    """
    places, forces = [], []
    for force in (TOUCH_N, *GIVE_N):
        rig.world.push(cell, force)
        rig.run(seconds)
        places.append(np.concatenate([rig.cell_place(cell), rig.centre_of_mass()]))
        forces.append(float(rig.world.contact_normal_force()[0]))
    return np.array(places), np.array(forces)
