# SPDX-License-Identifier: Apache-2.0
"""What a recording tells in a table: which links were touched, how hard, for how long."""

from __future__ import annotations

import time
from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from robotskin.record.recording import Recording
from robotskin.skin import Health

TOUCH_N = 0.5
FRAMES_PER_REPORT = 500


@dataclass(frozen=True)
class LinkTouch:
    """Touches of one link: how many of its cells felt more than `TOUCH_N`, the largest force of one, how long."""

    link: str
    cells: int
    largest_n: float
    seconds: float


@dataclass(frozen=True)
class Summary:
    """What a replay found; `speed` is in multiples of real time, `gaps` entries that the recorder dropped."""

    frames: int
    seconds: float
    speed: float
    gaps: int
    links: tuple[LinkTouch, ...]
    unplayed_s: float = 0.0
    """At its end, which no keyframe leads to any more."""

    def figures(self) -> dict[str, float]:
        """Flat numbers, as files of figures hold them."""
        return {
            "frames": self.frames,
            "seconds": self.seconds,
            "replay_speed": self.speed,
            "gaps": self.gaps,
            "unplayed_s": self.unplayed_s,
            **{f"largest_n_{row.link}": row.largest_n for row in self.links},
        }


def summarise(
    recording: Recording, start_s: float, end_s: float, progress: Callable[[float], None] = lambda done: None
) -> Summary:
    """Play a recording between two times (seconds from its beginning) and sum up its touches.

    What came before the first tare does not count: each sensor's own offset looks like a touch. `progress` is told
    how many seconds are done. Raises RecordingFileError for damaged bytes.
    """
    layout = recording.layout
    link = np.asarray(layout.link)
    largest = np.zeros(len(layout))
    touched_s = np.zeros(len(layout.links))
    frames = gaps = 0
    zeroed = False
    first_ns = last_ns = 0
    began = time.monotonic()
    for frame in recording.frames(start_s, end_s):
        force = np.asarray(frame.skin.normal_force).sum(axis=1)
        force[np.asarray(frame.skin.health) != int(Health.alive)] = 0
        if not zeroed and frame.zeroed:
            zeroed = True
            largest[:], touched_s[:] = 0, 0
        np.maximum(largest, force, out=largest)
        period_s = (frame.time_ns - last_ns) / 1e9 if frames else 0.0
        touched_s[np.unique(link[force > TOUCH_N])] += period_s
        first_ns = first_ns or frame.time_ns
        last_ns, gaps = frame.time_ns, frame.gaps
        frames += 1
        if frames % FRAMES_PER_REPORT == 0:
            progress((last_ns - first_ns) / 1e9)
    seconds = (last_ns - first_ns) / 1e9
    rows = [
        LinkTouch(
            layout.links[index],
            int((largest[link == index] > TOUCH_N).sum()),
            float(largest[link == index].max()),
            float(touched_s[index]),
        )
        for index in np.unique(link[largest > TOUCH_N])
    ]
    return Summary(
        frames, seconds, seconds / max(time.monotonic() - began, 1e-9), gaps, tuple(rows), recording.unplayed_s
    )
