# SPDX-License-Identifier: Apache-2.0
"""What each channel says for itself: silent, stuck, at the end of its range, overheated, noisy."""

from __future__ import annotations

from collections.abc import Iterator, Mapping

import numpy as np
from numpy.typing import NDArray
from scipy.sparse.csgraph import connected_components
from scipy.special import ndtr

from robotskin.health.evidence import Evidence
from robotskin.health.healthy import ACCELERATIONS, BOARD, FORCES, PROXIMITY, STEP, SURFACE
from robotskin.health.kinds import CHANNELS, Finding, Kind

NOISE_WINDOWS, NOISE_AT_LEAST = 8, 3
WHITE = 8.0
"""Times its standard deviation, within which a second of white noise stays."""
CALM = 4.0
"""Times the power of a sensor's noise, which the median cell of a link shows at most while it does not shake."""
THERMOMETER_WINDOWS, THERMOMETER_RATIO = 30, 3.2


def judged(evidence: Evidence) -> Iterator[Finding]:
    """Every cell that a channel of its own shows to be ill; a cell may come more than once."""
    yield from evidence.silence.judged(evidence.healthy.silent_s)
    yield from _at_end(evidence)
    yield from _stuck(evidence)
    yield from _hot(evidence)
    yield from _noisy(evidence)


def _at_end(evidence: Evidence) -> Iterator[Finding]:
    """A force or a proximity sensor may well be at its end while something touches the cell.

    An accelerometer of which no axis moves is stuck, wherever its axes stand; one axis alone at its end shows no noise.
    """
    long = evidence.at_end_s >= evidence.healthy.end_s
    long[:, BOARD:] = False  # that is heat
    ended = long[:, ACCELERATIONS]
    alive = np.all(ended | ~_unchanged(evidence)[:, ACCELERATIONS], axis=1)
    long[:, ACCELERATIONS] &= np.asarray(alive)[:, None]
    now = evidence.now
    near = now["mean"][:, PROXIMITY] > evidence.healthy.untouched_share
    long[:, FORCES] &= ~near[:, None]
    something = evidence.pressed | evidence.leant_on | evidence.came_near
    long[:, PROXIMITY] = _see_what_is_not_there(evidence, long[:, PROXIMITY] & ~something)
    for cell in np.flatnonzero(long.any(axis=1)):
        yield Finding(int(cell), Kind.end_of_range, _names(long[cell]))


def _see_what_is_not_there(evidence: Evidence, suspect: NDArray[np.bool_]) -> NDArray[np.bool_]:
    """(N) of the cells that seem to see something at their faces, those around which no other cell sees anything.

    Suspects beside each other are judged together: they cannot speak for each other, but a thing that lies on all of
    them is seen by those around. As many of these must be there to look.
    """
    cells = evidence.cells
    beside = (evidence.neighbours[:, :, None] == np.flatnonzero(suspect)).any(axis=1)[suspect]
    count, group = connected_components(beside, directed=False)
    sees = np.append(evidence.now["most"][:, PROXIMITY], 0.0)
    found = np.zeros(cells, bool)
    for number in range(count):
        members = np.flatnonzero(suspect)[group == number]
        around = np.setdiff1d(evidence.neighbours[members], [*members, cells])
        alone = sees[around].max(initial=0.0) < evidence.healthy.untouched_share
        found[members] = alone and (len(members) == 1 or len(around) >= len(members))
    return found


def _stuck(evidence: Evidence) -> Iterator[Finding]:
    """Noise moves a living channel within a few samples, but where it is at zero with its own zero below."""
    healthy, now = evidence.healthy, evidence.now
    count, seconds, value = now["unchanged"], now["unchanged_s"], now["mean"]
    fast = _unchanged(evidence)
    found = np.zeros(count.shape, bool)
    found[:, ACCELERATIONS] = fast[:, ACCELERATIONS]
    shown = value > 3.5 * STEP
    found[:, PROXIMITY] = fast[:, PROXIMITY] & shown[:, PROXIMITY]
    found[:, FORCES] = fast[:, FORCES] & (seconds[:, FORCES] >= 2 * healthy.stuck_s) & shown[:, FORCES]
    # A skin without proximity is another maker's: its forces may rest at zero, and have no noise to move them.
    ours = np.isfinite(value[:, PROXIMITY])
    moved = _by_link(evidence, count[:, FORCES].min(axis=1), now["samples"] > 0) < healthy.stuck_samples
    found[:, FORCES] &= (ours | moved)[:, None]
    at_zero = ours[:, None] & (count[:, FORCES] >= healthy.zero_samples) & (seconds[:, FORCES] >= healthy.zero_s)
    found[:, FORCES] |= at_zero
    found[:, SURFACE] = seconds[:, SURFACE] >= healthy.temperature_stuck_s
    found[:, SURFACE] &= count[:, SURFACE] >= healthy.stuck_samples
    found[:, PROXIMITY] |= evidence.blind
    found &= (now["samples"] > 0)[:, None] & (now["at_end"] < 0.5)
    told = evidence.stuck_s >= 1.0
    for cell in np.flatnonzero(found.any(axis=1) | told):
        yield Finding(int(cell), Kind.stuck, _names(found[cell]))


def _unchanged(evidence: Evidence) -> NDArray[np.bool_]:
    """(N, 9) of channels that have shown one value for longer than noise lets one."""
    healthy, now = evidence.healthy, evidence.now
    return np.asarray((now["unchanged"] >= healthy.stuck_samples) & (now["unchanged_s"] >= healthy.stuck_s))


def _hot(evidence: Evidence) -> Iterator[Finding]:
    """Against the cells of its link: a room may be warm, and a hand warms a few cells to its own temperature."""
    now, healthy = evidence.now, evidence.healthy
    known = (now["samples"] > 0) & np.isfinite(now["mean"][:, BOARD])
    board = now["mean"][:, BOARD]
    usual = _by_link(evidence, board, known)
    hotter = board - usual
    hot = known & ((hotter > healthy.hot_k) | (board > healthy.hot_c))
    for cell in np.flatnonzero(hot):
        yield Finding(int(cell), Kind.overheated, size=float(hotter[cell]), unit="K")


def _noisy(evidence: Evidence) -> Iterator[Finding]:
    """Against what is known of its sensor, and against the other cells, which feel the same motion."""
    last = evidence.last(NOISE_WINDOWS)
    if len(last["time"]) < NOISE_WINDOWS:
        return
    known = np.asarray((last["samples"] >= 3).all(axis=0))
    loud = _loudness(evidence, last, known)
    noisy = (loud > evidence.healthy.noise_ratio) & known[:, None]
    thermometer, usual = _thermometers(evidence)
    loud[:, SURFACE] = thermometer / usual
    noisy[:, SURFACE] = loud[:, SURFACE] > THERMOMETER_RATIO
    noisy[:, BOARD] = False  # its steps are larger than its noise
    for cell in np.flatnonzero(noisy.any(axis=1)):
        yield Finding(
            int(cell), Kind.noisy, _names(noisy[cell]), size=float(loud[cell][noisy[cell]].max()), unit="times"
        )


def _loudness(evidence: Evidence, last: Mapping[str, NDArray], known: NDArray[np.bool_]) -> NDArray[np.float64]:
    """(N, 9) noise of each channel over what is usual; 0 where no window tells.

    A jump, such as a touch, goes much further than noise that is as loud: its window tells nothing. Nor does one in
    which the cell's link shakes, since its far end shakes more than its near one. Of the others the quiet ones tell.
    """
    noise = _unclipped(last)
    tells = last["most"] - last["least"] < WHITE * last["noise"] + 2.5 * STEP
    usual = np.maximum(_by_link(evidence, noise, known), evidence.healthy.noise)
    floor = evidence.healthy.noise[ACCELERATIONS]
    power = _by_link(evidence, (noise[:, :, ACCELERATIONS] ** 2).sum(axis=2), known)
    # Cells of a link lie in many directions, so the median of an axis does not tell how it shakes; that of all three
    # together does.
    tells[:, :, ACCELERATIONS] &= (power < CALM * (floor**2).sum())[:, :, None]
    ratio = np.sort(np.where(tells, noise / np.maximum(usual, 1e-12), np.inf), axis=0)
    count = tells.sum(axis=0)
    # One window may be quiet by chance, but of the fewest none: a touch makes two of them loud.
    second = count > NOISE_AT_LEAST
    return np.where(count >= NOISE_AT_LEAST, np.where(second, ratio[1], ratio[0]), 0.0)


def _unclipped(last: Mapping[str, NDArray]) -> NDArray[np.float64]:
    """(K, N, 9) noise of each channel, also where its zero lies below what it can show, so that half of it is cut off.

    What is left of white noise of deviation s that is cut off below t s has a mean and a deviation whose ratio tells t.
    """
    noise = last["noise"].astype(float)
    clipped = (last["least"] <= 0) & (noise > 0)
    clipped[:, :, FORCES.stop :] = False
    ratio = last["mean"][clipped] / noise[clipped]
    noise[clipped] /= np.interp(ratio, *_CUT_OFF)
    return noise


def _cut_off() -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Mean over deviation of standard white noise that is cut off below t, rising, and its deviation."""
    t = np.linspace(2.5, -4.0, 131)
    density, above = np.exp(-(t**2) / 2) / np.sqrt(2 * np.pi), ndtr(-t)
    mean = density - t * above
    deviation = np.sqrt((1 + t**2) * above - t * density - mean**2)
    return mean / deviation, deviation


_CUT_OFF = _cut_off()


def _thermometers(evidence: Evidence) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """(N) noise of a window's mean of the fine thermometer, and what is usual; it measures but a few times a second."""
    last = evidence.last(THERMOMETER_WINDOWS)
    if len(last["time"]) < THERMOMETER_WINDOWS:
        return np.zeros(evidence.cells), np.ones(evidence.cells)
    # Fourth differences: skin that warms or cools in a touch does so smoothly, over a third of these windows or more.
    # What wanders over six seconds and more counts as warmth, too.
    fourth = np.abs(np.diff(last["mean"][:, :, SURFACE].astype(float), n=4, axis=0))
    # Where a touch begins or ends a few of them are large; the median does not see these.
    noise = np.median(fourth, axis=0) / (0.6745 * np.sqrt(70))
    known = np.asarray((last["samples"] >= 3).all(axis=0))
    usual = np.maximum(_by_link(evidence, noise, known), evidence.healthy.thermometer_noise_k)
    return np.where(known, noise, 0.0), usual


def _by_link(evidence: Evidence, values: NDArray, known: NDArray[np.bool_]) -> NDArray[np.float64]:
    """(N) or (K, N, …): the median of the cells of each cell's link, or of all where a link has few."""
    single = values.ndim == 1
    rows = values[None] if single else values
    medians = np.zeros_like(rows)
    if known.any():
        medians[:] = np.median(rows[:, known], axis=1, keepdims=True)
    for link in range(evidence.links):
        on = evidence.link == link
        if (known & on).sum() >= 5:
            medians[:, on] = np.median(rows[:, known & on], axis=1, keepdims=True)
    return medians[0] if single else medians


def _names(mask: NDArray[np.bool_]) -> tuple[str, ...]:
    """Of the channels of a row."""
    return tuple(CHANNELS[c] for c in np.flatnonzero(mask))
