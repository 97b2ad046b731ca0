# SPDX-License-Identifier: Apache-2.0
"""`robotskin bench control`, spread: a hand pushes alike through each interface; how far the answers differ."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from robotskin.choices import INTERFACES
from robotskin.robots.gains import GainSet
from robotskin.session import PERIOD_S, SafetyState, Session, SessionError
from robotskin_lab.bench.control_chain import chain, require_running, soft_cells, without_estimates
from robotskin_lab.bench.progress import tell

FORCES_N = (5.0, 15.0, 30.0)
HOLD_S, REST_S = 2.5, 2.5
RISE = (0.1, 0.9)
PATIENCE_S = 3.0

Figures = dict[str, float]


def spread_figures(seed: int, cells: int) -> Figures:
    """(max - min) / mean over the interfaces, of the displacement of the pushed cell of a UR5 and of its rise.

    Rise: from a tenth to nine tenths of the displacement. `interface_spread_worst` is the worst push of the two,
    `interface_spread` the worse of their means over pushes. `interface_spread_uncompensated*`: the same where no
    interface estimates friction and load; a third of the cells. `interface_pushes_stopped`: pushes at which the guard
    stopped the robot through one of the interfaces; they tell no spread.
    """
    gains = GainSet.load("ur5")
    answered = spreads(seed, cells, gains)
    whole = answered[~np.isnan(answered).any(axis=1)]
    bare = spreads(seed, max(1, cells // 3), without_estimates(gains))
    bare = bare[~np.isnan(bare).any(axis=1)]
    tell("")
    return {
        "interface_spread": float(whole.mean(axis=0).max()),
        "interface_spread_worst": float(whole.max()),
        "interface_spread_displacement": float(whole[:, 0].mean()),
        "interface_spread_displacement_worst": float(whole[:, 0].max()),
        "interface_spread_rise": float(whole[:, 1].mean()),
        "interface_spread_rise_worst": float(whole[:, 1].max()),
        "interface_spread_uncompensated": float(bare.mean(axis=0).max()),
        "interface_spread_uncompensated_worst": float(bare.max()),
        "interface_pushes": float(len(whole)),
        "interface_pushes_stopped": float(len(answered) - len(whole)),
    }


def spreads(
    seed: int,
    count: int,
    gains: GainSet,
    interfaces: Sequence[str] = INTERFACES,
    forces_n: Sequence[float] = FORCES_N,
) -> NDArray[np.float64]:
    """(pushes, 2) of displacement and rise, of so many cells with each force; NaN where the guard stopped the robot."""
    answers = []
    for interface in interfaces:
        session = chain("ur5", "skin_compliance", interface, seed, gains=gains)
        cells = soft_cells(session, count, np.random.default_rng(seed))
        session.boot()
        session.run(REST_S)
        for cell in cells:
            tell(f"spread: {interface}, cell {cell}")
            answers.append([_answer(session, cell, force) for force in forces_n])
        session.shut_down()
    values = np.array(answers).reshape(len(interfaces), -1, 2)
    return np.asarray((values.max(axis=0) - values.min(axis=0)) / values.mean(axis=0))


def _answer(session: Session, cell: int, force_n: float) -> tuple[float, float]:
    """Metres by which a push moves a cell in the end, and seconds from a tenth to nine tenths of that."""
    start = session.cell_position(cell)
    session.world.push(cell, force_n)
    for _ in range(round(PATIENCE_S / PERIOD_S)):
        session.step()
        if session.world.contact_normal_force().sum() > 0:
            break
    else:
        raise SessionError(f"the hand did not reach cell {cell} within {PATIENCE_S} s")
    moved = np.empty(round(HOLD_S / PERIOD_S))
    for tick in range(len(moved)):
        session.step()
        moved[tick] = np.linalg.norm(session.cell_position(cell) - start)
    session.world.release()
    session.run(REST_S)
    if session.state not in (SafetyState.running, SafetyState.degraded):
        tell(f"spread: {force_n} N on cell {cell}: the robot stopped: {session.why_not_running()}")
        session.stop()
        session.run(1.0)
        session.start()
        session.run(2 * REST_S)
        require_running(session, f"after {force_n} N on cell {cell}")
        return np.nan, np.nan
    end = float(moved[-100:].mean())
    first, last = (int(np.argmax(moved >= share * end)) for share in RISE)
    return end, PERIOD_S * (last - first)
