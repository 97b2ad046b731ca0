# SPDX-License-Identifier: Apache-2.0
"""Gain, offset and crosstalk of each cell's sensors from its presses: least squares with what is known beforehand.

Errors that stay the same through many moments, such as friction, a lever or the place, are no noise: they stand in
the covariance of the moments, so that many moments do not make them small.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable
from dataclasses import dataclass
from datetime import UTC, datetime

import numpy as np
from scipy.linalg import block_diag, cho_factor, cho_solve

from robotskin.calibration.calibration import Calibration, can_be
from robotskin.calibration.force_sensors import CROSS, GAIN, OFFSET, PARAMETERS, UNTOUCHED, Array, felt, shares, shown
from robotskin.calibration.presses import Presses
from robotskin.layout import Layout
from robotskin.selfconfig.common.one_thread import one_thread

Moments = tuple[Callable[[Array], Array], Array]
"""What is left of all moments as a function of the parameters, and its covariance."""
STEPS = 8
STEP = 1e-5
LEAST_N = 0.05
"""A sensor that shows less may be at the end of its range."""


@dataclass(frozen=True)
class Known:
    """What is known before anything is pressed, as standard deviations unless told otherwise.

    gain, cross, offset_n: of new sensors, half the width of their range. rest_n: of the mean of readings at
    rest, in which preload has crept; reading_n: of one reading.
    force_share: hysteresis and creep of a reading, share of it; gain_share: of them, what all readings of a sensor have
    in common; creep_n: what creep and the slow wave of a zero add to all of them. place_m: of a press on the cell's
    face, the same for all presses of a cell. probe_share: of the probe. torque_nm: noise of a joint's torque;
    before_nm: of the torque before a touch, which is taken off. friction_nm: (n) what is not known of a joint's
    friction. lever_share: of the levers.
    """

    gain: float = 0.2
    cross: float = 0.05
    offset_n: float = 0.2
    rest_n: float = 0.015
    reading_n: float = 0.01
    force_share: float = 0.02
    gain_share: float = 0.005
    creep_n: float = 0.017
    place_m: float = 0.001
    probe_share: float = 0.01
    torque_nm: float = 0.2
    before_nm: float = 0.05
    friction_nm: tuple[float, ...] = ()
    lever_share: float = 0.01


@one_thread
def calibrate(layout: Layout, presses: Iterable[Presses], known: Known | None = None, *, method: str) -> Calibration:
    """The calibration of the cells that were pressed; those whose presses fit no sensor are left out.

    Args:
        layout: of N cells. presses: of different cells. known: beforehand. method: how it was done, for the file.
    """
    known, listed = known or Known(), list(presses)
    soft, soft_error = soft_share(listed)
    parameters = np.tile(UNTOUCHED, (len(layout), 1))
    covariance = np.zeros((len(layout), PARAMETERS, PARAMETERS))
    calibrated = np.zeros(len(layout), bool)
    for one in listed:
        found, uncertain = estimated(one, known, soft, soft_error)
        if can_be(found):
            parameters[one.cell], covariance[one.cell], calibrated[one.cell] = found, uncertain, True
    date = datetime.now(UTC).isoformat(timespec="seconds")
    return Calibration.of(layout, parameters, covariance, calibrated, date=date, method=method, soft_share=soft)


def soft_share(presses: list[Presses]) -> tuple[float, float]:
    """Share of a force that the soft layer carries to each neighbour, over all cells, and its standard deviation."""
    found = []
    for one in presses:
        told = np.isfinite(one.carried_n)
        total = (one.reading_n - np.maximum(one.rest_n, 0)).sum(axis=1)[told]
        if told.any() and total @ total > 0:
            ratio = float(total @ one.carried_n[told] / (total @ total))  # of what the pressed cell keeps
            found.append(ratio / (1 + one.neighbours * ratio))
    if len(found) < 3:
        return 0.0, 0.03
    return float(np.mean(found)), float(np.std(found) / np.sqrt(len(found)))


def estimated(one: Presses, known: Known, soft: float, soft_error: float) -> tuple[Array, Array]:
    """(12,) and (12, 12): the parameters of one cell's sensors and their covariance."""
    mean, prior = _before(one, known)
    kept = 1 - one.neighbours * soft
    scale_error = one.neighbours * soft_error / kept
    moments = _probe if one.force_n is not None else _torque
    residual, covariance = moments(one, known, kept, scale_error)
    information = np.diag(1 / prior**2)
    factor = cho_factor(covariance)
    found, normal = mean.copy(), information
    for _ in range(STEPS):
        error = residual(found)
        slope = np.stack([(residual(found + STEP * axis) - error) / STEP for axis in np.eye(PARAMETERS)], axis=1)
        normal = information + slope.T @ cho_solve(factor, slope)
        step = np.linalg.solve(normal, slope.T @ cho_solve(factor, error) + information @ (found - mean))
        found = found - step
        if np.abs(step).max() < 1e-7:
            break
    return found, np.linalg.inv(normal).astype(np.float64)


def _before(one: Presses, known: Known) -> tuple[Array, Array]:
    """(12,) mean and standard deviation before any press: a positive offset shows at rest, a negative one does not."""
    mean, deviation = UNTOUCHED.copy(), np.empty(PARAMETERS)
    deviation[GAIN], deviation[CROSS] = known.gain / np.sqrt(3), known.cross / np.sqrt(3)
    seen = one.rest_n > LEAST_N
    mean[OFFSET] = np.where(seen, one.rest_n, -known.offset_n / 2 + one.rest_n)
    deviation[OFFSET] = np.where(seen, known.rest_n, np.hypot(known.offset_n / np.sqrt(12), known.rest_n))
    return mean, deviation


def share_slopes(place_m: Array) -> Array:
    """(K, 3, 2) change of the shares with the place, 1/m."""
    small = 1e-5
    return np.stack(
        [(shares(place_m + small * axis) - shares(place_m - small * axis)) / (2 * small) for axis in np.eye(2)], -1
    )


def _probe(one: Presses, known: Known, kept: float, scale_error: float) -> Moments:
    assert one.force_n is not None
    force = kept * one.force_n
    share, slopes = shares(one.place_m), share_slopes(one.place_m)
    used = (one.reading_n > LEAST_N).ravel()
    noise = (known.reading_n**2 + (known.force_share * one.reading_n) ** 2).ravel()
    common = np.hypot(known.probe_share, scale_error) * (force[:, None] * share).ravel()
    moved = known.place_m * (force[:, None, None] * slopes).reshape(-1, 2)
    covariance = np.diag(noise) + np.outer(common, common) + moved @ moved.T
    for sensor in range(3):  # what hysteresis and creep do to a gain does not become less by more readings
        own = known.gain_share * one.reading_n * (np.arange(3) == sensor)
        crept = known.creep_n * np.tile(np.arange(3) == sensor, len(force))
        covariance += np.outer(own.ravel(), own.ravel()) + np.outer(crept, crept)
    covariance = covariance[np.ix_(used, used)]

    def residual(parameters: Array) -> Array:
        return (shown(parameters, force[:, None] * share) - one.reading_n).ravel()[used]

    return residual, covariance


def _torque(one: Presses, known: Known, kept: float, scale_error: float) -> Moments:
    assert one.torque_nm is not None
    assert one.lever_nm_per_n is not None
    assert one.direction is not None
    used = (one.reading_n > LEAST_N).all(axis=1)
    reading, lever = one.reading_n[used], one.lever_nm_per_n[used] / kept
    torque, direction = one.torque_nm[used], one.direction[used]
    force = np.maximum(reading - one.rest_n, 0).sum(axis=1)  # as a measure of size alone
    joints = torque.shape[1]
    friction = np.array(known.friction_nm or np.zeros(joints))
    share, slopes = shares(one.place_m[used]), share_slopes(one.place_m[used])
    expected = (lever * force[:, None]).T  # (n, K)
    noise = known.torque_nm**2 + (known.force_share * expected) ** 2
    blocks = [
        np.diag(noise[j]) + known.before_nm**2 + friction[j] ** 2 * np.outer(direction[:, j], direction[:, j])
        for j in range(joints)
    ]
    torques = block_diag(*blocks)
    common = np.hypot(known.lever_share, scale_error) * expected.ravel()
    crept = np.sqrt(3) * known.creep_n * lever.T.ravel()
    torques += np.outer(common, common) + np.outer(crept, crept)
    moved = known.place_m * (force[:, None, None] * slopes[:, :2]).reshape(-1, 2)
    own_noise = known.reading_n**2 + (known.force_share * reading[:, :2]) ** 2
    split = np.diag(own_noise.ravel()) + moved @ moved.T
    for sensor in range(3):  # what one sensor shows too much makes it seem to have a larger share
        wrong = ((np.arange(3) == sensor) - share)[:, :2]
        crept, own = known.creep_n * wrong, known.gain_share * reading[:, sensor, None] * wrong
        split += np.outer(crept, crept) + np.outer(own, own)
    covariance = block_diag(torques, split)

    def residual(parameters: Array) -> Array:
        each = felt(parameters, reading)
        total = each.sum(axis=1)
        off = (lever * total[:, None] - torque).T.ravel()
        return np.concatenate([off, (each - share * total[:, None])[:, :2].ravel()])

    return residual, covariance
