# SPDX-License-Identifier: Apache-2.0
"""A probe of known force goes from cell to cell of a simulated robot; what is shown comes through the whole chain."""

from __future__ import annotations

from collections.abc import Callable, Iterable

import numpy as np

from robotskin.calibration.force_sensors import Array
from robotskin.calibration.presses import Presses
from robotskin.session import PERIOD_S, Session

PLACES_M = 0.006 * np.array([[0.0, 1.0], [-0.87, -0.5], [0.87, -0.5]])
LEVELS_N = (2.0, 5.0, 8.0, 5.0, 2.0)
STAY_S, REST_S = 0.12, 0.2
ARRIVES_WITHIN_S = 2.0
OWN_SHARE, ALONE = 0.5, 0.95
"""Of the probe's force, which the cell itself feels at least; and of that share where it is greatest. Else the probe
leans on something else, too."""
MOMENTS_AT_LEAST = 6


def probed(session: Session, cells: Iterable[int], tell: Callable[[float], None] = lambda share: None) -> list[Presses]:
    """Press each of the cells of a booted session at three places; tell hears the share that is done.

    The robot must stand still: give the session a behaviour that holds its posture. Cells that the probe does not
    reach, such as those behind others, are left out.
    """
    listed = list(cells)
    found = []
    for number, cell in enumerate(listed):
        if (one := _pressed(session, cell)) is not None:
            found.append(one)
        tell((number + 1) / len(listed))
    return found


def _shown(session: Session) -> Array:
    return np.asarray(session.reader.measured_force, dtype=float).copy()


def _arrives(session: Session, force_n: float) -> bool:
    """Whether the probe comes to its force."""
    for _ in range(round(ARRIVES_WITHIN_S / PERIOD_S)):
        session.step()
        if abs(float(session.world.contact_normal_force().sum()) - force_n) < 0.1 * force_n:
            session.run(STAY_S)
            return True
    return False


def _pressed(session: Session, cell: int) -> Presses | None:
    session.world.release()
    session.run(REST_S)
    rest = []
    for _ in range(5):
        session.run(0.01)
        rest.append(_shown(session))
    rest_n = np.mean(rest, axis=0)
    beside = [int(one) for one in session.layout.neighbours[cell, :, 0] if one >= 0]
    tell = rest_n[beside] > 0.05
    reading, place, force, carried, own = [], [], [], [], []
    for at in PLACES_M:
        for level in LEVELS_N:
            session.world.push(session.in_world(cell), level, (float(at[0]), float(at[1])))
            if not _arrives(session, level):
                break
            shown = _shown(session)
            reading.append(shown[cell])
            place.append(at)
            force.append(float(session.world.contact_normal_force().sum()))
            own.append(session.world.cell_true_force()[session.in_world(cell)].sum() / max(force[-1], 1e-9))
            change = (shown - rest_n)[beside][tell]
            carried.append(3 * change.mean() if tell.any() else np.nan)
        session.world.release()
        session.run(0.05)
    share = np.array(own)
    alone = share >= max(OWN_SHARE, ALONE * share.max(initial=0.0))
    if alone.sum() < MOMENTS_AT_LEAST:
        return None
    return Presses(
        cell=cell,
        neighbours=len(beside),
        rest_n=rest_n[cell],
        reading_n=np.array(reading)[alone],
        place_m=np.array(place)[alone],
        carried_n=np.array(carried)[alone],
        force_n=np.array(force)[alone],
    )
