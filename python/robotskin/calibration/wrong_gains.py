# SPDX-License-Identifier: Apache-2.0
"""Force sensors that show too much or too little, found from some twenty touches of known force or joint torques.

What three sensors show above rest, a, times their inverse gains w, is the force of the touch: F = a w, wherever on the
cell it is. Where it is tells which share s of it each sensor has: a_i w_i = s_i F, which tells one sensor from the
others even where the force is poorly known. Each explanation lets one inverse gain, or all by one factor, be anything;
the rest are about 1.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from scipy.linalg import block_diag

from robotskin.calibration.estimate import Known, share_slopes
from robotskin.calibration.force_sensors import Array, shares
from robotskin.calibration.presses import Presses
from robotskin.health.healthy import FORCES
from robotskin.health.kinds import CHANNELS, Finding, Kind
from robotskin.selfconfig.common.one_thread import one_thread

HEALTHY, COMMON = 0.03, 0.03
"""Standard deviations of an inverse gain: of one sensor, and of what the cell's three have in common."""
SOFT_UNKNOWN = 0.1
"""The same of what they have in common where too few cells were pressed to tell what the soft layer carries away."""
ANYTHING = 0.5
BETTER = 15.0
LEAST = 0.12
LEAST_TOLD_N = 0.5
"""A touch that never felt more tells nothing of shares."""
CELLS_AT_LEAST = 5
TOUCHES_AT_LEAST = 5
"""Whose places tell how well they are known."""
REGISTERED = 3.0
"""Times the error of a place, by which all places of a cell together may be off."""
EXPLANATIONS: tuple[tuple[int, ...], ...] = ((0,), (1,), (2,), (0, 1, 2))


@one_thread
def wrong_gains(presses: Sequence[Presses], known: Known | None = None) -> list[Finding]:
    """The cells of those pressed whose force sensors are mis-scaled, best after twenty touches of each.

    The soft layer carries a share of each touch to the neighbours. It is told by all pressed cells together.
    """
    known = known or Known()
    soft = _soft_share(presses)
    common = COMMON if soft is not None else SOFT_UNKNOWN
    judged = (_judged(one, known, 1 - one.neighbours * (soft or 0.0), common) for one in presses)
    return [finding for finding in judged if finding is not None]


def _soft_share(presses: Sequence[Presses]) -> float | None:
    """Of a force to each neighbour: the median over the cells, which some ill ones do not move."""
    if len(presses) < CELLS_AT_LEAST:
        return None
    found = []
    for one in presses:
        lever, reference = _reference(one)
        shown = lever * _above_rest(one).sum(axis=1)[:, None]
        # What is shown has far less noise than the torques, so it must be the one that is squared.
        found.append((1 - float((shown**2).sum() / (shown * reference).sum())) / max(one.neighbours, 1))
    return float(np.median(found))


def _above_rest(one: Presses) -> Array:
    """(K, 3) newton."""
    return np.maximum(one.reading_n - one.rest_n, 0.0)


def _reference(one: Presses) -> tuple[Array, Array]:
    """(K, J) what a newton shows on each of J gauges, the probe or the joints, and (K, J) what they showed."""
    if one.force_n is not None:
        return np.ones((len(one.force_n), 1)), one.force_n[:, None]
    assert one.lever_nm_per_n is not None
    assert one.torque_nm is not None
    return one.lever_nm_per_n, one.torque_nm


def _judged(one: Presses, known: Known, kept: float, common: float) -> Finding | None:
    above = _above_rest(one)
    lever, reference = _reference(one)
    square, side = np.zeros((3, 3)), np.zeros(3)
    for gauge in range(lever.shape[1]):
        rows = lever[:, [gauge]] / kept * above
        whole = np.linalg.cholesky(_noise(one, known, gauge))
        rows, off = np.linalg.solve(whole, rows), np.linalg.solve(whole, reference[:, gauge] - rows.sum(axis=1))
        square += rows.T @ rows
        side += rows.T @ off
    rows, off = _split(one, known)
    square += rows.T @ rows
    side += rows.T @ off
    before = HEALTHY**2 * np.eye(3) + common**2
    healthy, _ = _cost(square, side, before)
    best, size, which = np.inf, 0.0, EXPLANATIONS[0]
    for sensors in EXPLANATIONS:
        free = np.isin(np.arange(3), sensors).astype(float)
        cost, numbers = _cost(square, side, before + ANYTHING**2 * np.outer(free, free))
        if cost < best:
            best, which, size = cost, sensors, 1 / (1 + float(numbers[list(sensors)].mean()))
    if healthy - best < BETTER or abs(size - 1) < LEAST:
        return None
    channels = tuple(CHANNELS[FORCES.start + sensor] for sensor in which)
    return Finding(one.cell, Kind.mis_scaled, channels, size=size, unit="times")


def _split(one: Presses, known: Known) -> tuple[Array, Array]:
    """(2 T, 3) and (2 T) of T touches, in standard deviations: how the numbers show in what two of the sensors have of
    the whole beyond their shares, and what is left over where all are 0.

    How well places are known is seen in what no numbers explain; it is never taken to be less than `known` says.
    """
    above = _above_rest(one)
    begins = np.flatnonzero(np.append(True, (np.diff(one.place_m, axis=0) != 0).any(axis=1)))
    rows, off, noise, moved = [], [], [], []
    for touch in np.split(np.arange(len(above)), begins[1:]):
        share, total = shares(one.place_m[touch[0]]), above[touch].sum(axis=1)
        if total.max() < LEAST_TOLD_N:
            continue
        weight = total / (total @ total)
        shown = weight @ above[touch]  # (3) of a newton
        # By what is shown, not by the place, whose errors would then seem to be gains.
        rows.append((np.diag(shown) - np.outer(shown, shown))[:2])
        off.append((share - shown)[:2])
        slopes = known.place_m * share_slopes(one.place_m[touch[:1]])[0, :2]
        crept = known.creep_n * weight.sum()
        noise.append(slopes @ slopes.T + np.diag((known.force_share * shown[:2]) ** 2 + crept**2))
        moved.append(REGISTERED * slopes)
    if len(rows) < TOUCHES_AT_LEAST:
        return np.zeros((0, 3)), np.zeros(0)
    together = np.concatenate(moved)
    whole = np.linalg.cholesky(block_diag(*noise) + together @ together.T)
    white, left = np.linalg.solve(whole, np.concatenate(rows)), np.linalg.solve(whole, np.concatenate(off))
    over = left - white @ np.linalg.lstsq(white, left)[0]
    worse = np.sqrt(max(1.0, float(over @ over) / (len(left) - 2)))  # a common factor does not show in shares
    return white / worse, left / worse


def _cost(square: Array, side: Array, before: Array) -> tuple[float, Array]:
    """The least sum of squares but for a constant, and the numbers (3): inverse gains less 1."""
    numbers = np.linalg.solve(square + np.linalg.inv(before), side)
    return -float(side @ numbers), numbers.astype(np.float64)


def _noise(one: Presses, known: Known, gauge: int) -> Array:
    """(K, K) covariance of what is left over on a gauge."""
    lever, reference = (values[:, gauge] for values in _reference(one))
    alone = (known.force_share * reference) ** 2 + 3 * (known.reading_n * lever) ** 2
    if one.direction is None:
        return np.diag(alone + (known.probe_share * reference) ** 2)
    friction = known.friction_nm[gauge] if known.friction_nm else 0.0
    turning = one.direction[:, gauge]
    return np.diag(alone + known.torque_nm**2) + known.before_nm**2 + friction**2 * np.outer(turning, turning)
