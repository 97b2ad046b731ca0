# SPDX-License-Identifier: Apache-2.0
"""Events if both ends predict: frames of many contacts by predictor, all with the error bound of send-on-delta."""

from __future__ import annotations

from collections.abc import Callable
from typing import Annotated, Any

import numpy as np
import typer
from numpy.typing import NDArray

from robotskin import robots
from robotskin.firmware import REFRESH_US
from robotskin.layout import finished
from robotskin.world import World
from robotskin_lab.bench.event_rig import palm_places
from robotskin_lab.bench.event_streams import THRESHOLDS, record
from robotskin_lab.bench.events import MANY_ACTIVE, MANY_MOVING, MANY_SETTLE_S
from robotskin_lab.bench.stimulus import ACTIVE_SHARE, Palms, palms

TOUCH = slice(0, 4)
"""Proximity and forces: the channels that make events."""
REFRESH_STEPS = REFRESH_US // 1000
SHORT_STEPS = 20

Values = NDArray[np.float64]


class Hold:
    """The value last sent."""

    def __init__(self, first: Values) -> None:
        self.sent, self.before = first.copy(), first.copy()
        self.steps = np.ones((len(first), 1))  # between the two

    def predict(self, since: Values) -> Values:
        """(N, C) what both ends expect so many steps (N, 1) after the last frame."""
        del since
        return self.sent

    def take(self, cells: NDArray[np.bool_], sample: Values, since: Values) -> None:
        """These cells send this sample."""
        self.before[cells], self.sent[cells] = self.sent[cells], sample[cells]
        self.steps[cells] = since[cells]


class Linear(Hold):
    """On along the line through the last two values sent."""

    share = 1.0
    longest = np.inf

    def predict(self, since: Values) -> Values:
        """(N, C) on the line."""
        slope = self.share * (self.sent - self.before) / self.steps
        return np.rint(self.sent + slope * np.minimum(since, self.longest))


class LinearShort(Linear):
    """Likewise for 20 ms, then constant."""

    longest = SHORT_STEPS


class LinearHalf(Linear):
    """At half the slope."""

    share = 0.5


class Better(Linear):
    """Of `Hold` and `Linear` the one that would have been nearer to the value last sent, by channel."""

    def __init__(self, first: Values) -> None:
        super().__init__(first)
        self.moves = np.zeros(first.shape, dtype=bool)

    def predict(self, since: Values) -> Values:
        """(N, C) of the better one."""
        return np.where(self.moves, super().predict(since), self.sent)

    def take(self, cells: NDArray[np.bool_], sample: Values, since: Values) -> None:
        """These cells send this sample, and both ends see which was nearer."""
        line, held = np.abs(super().predict(since) - sample), np.abs(self.sent - sample)
        self.moves[cells] = (line < held)[cells]
        super().take(cells, sample, since)


class Lead(Hold):
    """No prediction, but what is sent lies half a threshold ahead in channels that have moved by one."""

    def take(self, cells: NDArray[np.bool_], sample: Values, since: Values) -> None:
        """These cells send this sample, or what lies ahead of it."""
        moved = sample - self.sent
        delta = THRESHOLDS[TOUCH]
        ahead = np.where(np.abs(moved) >= delta, np.sign(moved) * (delta // 2), 0)
        super().take(cells, sample + ahead, since)


PREDICTORS: dict[str, Callable[[Values], Hold]] = {
    "hold": Hold,
    "linear": Linear,
    "linear_20_ms": LinearShort,
    "linear_half_slope": LinearHalf,
    "better_of_both": Better,
    "lead": Lead,
}


def frames_sent(counts: NDArray[np.int32], made: Callable[[Values], Hold]) -> tuple[int, int]:
    """Frames of (T, N, 9) counts at 1 kHz, refreshes included, and samples beyond the error bound.

    The law: |reconstructed - sampled| < threshold at every sample, in each channel that makes events.
    """
    samples = counts[:, :, TOUCH].astype(float)
    predictor = made(samples[0])
    since = np.zeros((samples.shape[1], 1))
    frames = violations = 0
    for sample in samples[1:]:
        since += 1
        wrong = (np.abs(predictor.predict(since) - sample) >= THRESHOLDS[TOUCH]).any(axis=1)
        cells = wrong | (since[:, 0] >= REFRESH_STEPS)
        predictor.take(cells, sample, since)
        since[cells] = 0
        frames += int(cells.sum())
        violations += int((np.abs(predictor.predict(since) - sample) >= THRESHOLDS[TOUCH]).sum())
    return frames, violations


def run(
    *, seed: int = 1, seconds: Annotated[float, typer.Option(help="Of samples at 1 kHz.", min=0.1)] = 2.0
) -> dict[str, Any]:
    """Count the frames of Talos in many hands (`robotskin bench events`) by what both ends predict, noise on.

    From samples of every cell, without a network: frames that a line has no room for count, too.
    """
    robot, layout = robots.load("talos"), finished("talos")
    cells = palm_places(robot, layout, seed, MANY_ACTIVE)
    world = World(layout, robot, seed, hands=palms(len(cells)), powered=False)
    rest = np.array(world.body.sample_all(0), dtype=np.int64)
    touch = Palms(world, cells, seed, MANY_MOVING)
    counts = record(world, touch.drive, MANY_SETTLE_S, seconds)
    above = counts[::50, :, TOUCH] - rest[None, :, TOUCH]
    active = (above > ACTIVE_SHARE * np.array([65536, 1024, 1024, 1024])).any(axis=2).sum(axis=1)
    figures: dict[str, Any] = {"cells_active": int(active.min()), "seconds": seconds}
    for name, made in PREDICTORS.items():
        frames, violations = frames_sent(counts, made)
        figures[f"frames_per_s_{name}"] = frames / seconds
        figures[f"reconstruction_violations_{name}"] = violations
    return figures
