# SPDX-License-Identifier: Apache-2.0
"""Cells of a simulated skin fall ill at random, to see that they are found."""

from __future__ import annotations

from typing import Any

import numpy as np
from scipy.spatial.transform import Rotation

from robotskin.health.kinds import ILLNESSES, Kind
from robotskin.session import Session
from robotskin.simulator import SensorFaultKind

FORCES, ACCELERATIONS = (1, 2, 3), (4, 5, 6)
STUCK_SETS = (tuple(range(9)), (0,), (1,), (2,), (3,), ACCELERATIONS, (8,), (7, 8))
NOISY_SETS = ((0,), (1,), (2,), (3,), FORCES, ACCELERATIONS, (4,), (5,), (6,), (8,))
END_SETS = ((0,), (1,), (2,), (3,), FORCES, (4,), (5,), (6,))
NOISE_TIMES = 5.0


def fall_ill(session: Session, count: int) -> dict[int, Kind]:
    """Let so many cells of a session fall ill from now on; which, and of what."""
    draw = np.random.default_rng([session.seed, 29])
    world = session.world
    out: dict[int, Kind] = {}
    cells = [int(cell) for cell in draw.permutation(len(session.layout))]
    while len(out) < count and cells:
        cell, kind = cells.pop(), ILLNESSES[int(draw.integers(len(ILLNESSES)))]
        place = session.in_world(cell)
        if kind is Kind.dead:
            world.network.kill(place)
        elif kind is Kind.swapped:
            if not cells:
                continue
            other = cells.pop()
            world.body.swap_cells(place, session.in_world(other))
            out[other] = kind
        else:
            fault = getattr(SensorFaultKind, kind.name)
            world.body.set_sensor_fault(place, fault, begin_s=world.time_s, **parts_of(draw, kind))
        out[cell] = kind
    return out


def parts_of(draw: np.random.Generator, kind: Kind) -> dict[str, Any]:
    """Channels, size and turn of a fault."""
    sign = float(draw.choice([-1.0, 1.0]))
    if kind is Kind.stuck:
        return {"channels": list(STUCK_SETS[int(draw.integers(len(STUCK_SETS)))])}
    if kind is Kind.noisy:
        return {"channels": list(NOISY_SETS[int(draw.integers(len(NOISY_SETS)))]), "size": NOISE_TIMES}
    if kind is Kind.drifting:
        return {"channels": [int(draw.choice(FORCES))], "size": 0.05}
    if kind is Kind.offset:
        if draw.random() < 0.5:
            return {"channels": [int(draw.choice(FORCES))], "size": 1.0}
        return {"channels": [int(draw.choice(ACCELERATIONS))], "size": 0.1 * sign}
    if kind is Kind.mis_scaled:
        which = [list(ACCELERATIONS), *([axis] for axis in ACCELERATIONS)][int(draw.integers(4))]
        return {"channels": which, "size": 1 + 0.3 * sign}
    if kind is Kind.loose:
        axis = draw.normal(size=3)
        turn = Rotation.from_rotvec(np.radians(draw.uniform(5, 30)) * axis / np.linalg.norm(axis)).as_matrix()
        return {"turn": turn.ravel().tolist()}
    if kind is Kind.overheated:
        return {"channels": [7, 8], "size": float(draw.uniform(20, 50))}
    if kind is Kind.end_of_range:
        channels = list(END_SETS[int(draw.integers(len(END_SETS)))])
        return {"channels": channels, "size": sign if channels[0] in ACCELERATIONS else 1.0}
    return {}
