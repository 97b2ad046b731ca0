# SPDX-License-Identifier: Apache-2.0
"""A probe of known force goes from cell to cell of a simulated robot; what is shown comes through the whole chain."""

from __future__ import annotations

from collections.abc import Callable, Iterable

import numpy as np

from robotskin.calibration.force_sensors import Array
from robotskin.calibration.presses import Presses
from robotskin.session import Session

PLACES_M = 0.006 * np.array([[0.0, 1.0], [-0.87, -0.5], [0.87, -0.5]])
LEVELS_N = (2.0, 5.0, 8.0, 5.0, 2.0)
STAY_S, REST_S = 0.12, 0.2


def probed(session: Session, cells: Iterable[int], tell: Callable[[float], None] = lambda share: None) -> list[Presses]:
    """Press each of the cells of a booted session at three places; tell hears the share that is done.

    The robot must stand still: give the session a behaviour that holds its posture.
    """
    listed = list(cells)
    found = []
    for number, cell in enumerate(listed):
        found.append(_pressed(session, cell))
        tell((number + 1) / len(listed))
    return found


def _shown(session: Session) -> Array:
    return np.asarray(session.reader.measured_force, dtype=float).copy()


def _pressed(session: Session, cell: int) -> Presses:
    session.world.release()
    session.run(REST_S)
    rest = []
    for _ in range(5):
        session.run(0.01)
        rest.append(_shown(session))
    rest_n = np.mean(rest, axis=0)
    beside = [int(one) for one in session.layout.neighbours[cell, :, 0] if one >= 0]
    tell = rest_n[beside] > 0.05
    reading, place, force, carried = [], [], [], []
    for at in PLACES_M:
        for level in LEVELS_N:
            session.world.push(session.in_world(cell), level, (float(at[0]), float(at[1])))
            session.run(STAY_S)
            shown = _shown(session)
            reading.append(shown[cell])
            place.append(at)
            force.append(float(session.world.contact_normal_force().sum()))
            change = (shown - rest_n)[beside][tell]
            carried.append(3 * change.mean() if tell.any() else np.nan)
        session.world.release()
        session.run(0.05)
    return Presses(
        cell=cell,
        neighbours=len(beside),
        rest_n=rest_n[cell],
        reading_n=np.array(reading),
        place_m=np.array(place),
        carried_n=np.array(carried),
        force_n=np.array(force),
    )
