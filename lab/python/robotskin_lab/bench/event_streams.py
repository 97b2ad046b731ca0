# SPDX-License-Identifier: Apache-2.0
"""Events computed off-line from recorded samples: by the ideal sensor, by send-on-delta, and cut into packets."""

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from robotskin import firmware
from robotskin.world import World

CHANNEL_BITS = np.array([bits for _, _, bits, _, _ in firmware.CHANNELS])
THRESHOLDS = np.array([counts for _, counts in firmware.EVENT_THRESHOLDS])
"""Counts, the firmware's default: the published second standard set."""
FIXED_BITS = 8 * firmware.FRAME_BYTES - int(CHANNEL_BITS.sum())
"""Type, source, sequence, hops left, time, flags and checksum of a sample frame."""
MASK_BITS = len(CHANNEL_BITS)
REFRESH_STEPS = 250
"""Milliseconds after which every value is sent again if it was not sent anyway."""

Counts = NDArray[np.int32]
Events = NDArray[np.bool_]


def record(world: World, drive: Callable[[float], None], settle_s: float, seconds: float) -> Counts:
    """(T, N, 9) counts of all cells, sampled each millisecond once settled, while `drive(time_s)` stimulates."""
    rows = []
    settle = round(1000 * settle_s)
    for step in range(settle + round(1000 * seconds)):
        drive(world.time_s)
        world.step(0.001)
        if step >= settle:
            rows.append(world.body.sample_all(step * 1_000_000))
    return np.array(rows)


def send_on_delta(counts: Counts, thresholds: NDArray[np.float64], channels: Events, whole: bool = False) -> Events:
    """(T, N, 9) which channels make an event at which sample [Cheng19 eq. 6, 7].

    A channel is compared with its own value last sent: that of its own last event or, where a frame carries the `whole`
    sample, that of the cell's last event.
    """
    reference = counts[0].astype(float)
    events = np.zeros(counts.shape, dtype=bool)
    for k in range(1, len(counts)):
        events[k] = (np.abs(counts[k] - reference) >= thresholds) & channels
        sent = events[k].any(axis=1, keepdims=True) if whole else events[k]
        reference = np.where(sent, counts[k], reference)
    return events


def ideal_events(counts: Counts, thresholds: NDArray[np.float64], channels: Events) -> float:
    """Events of the ideal, unsampled sensor [Cheng19 eq. 4, 5]: one whenever the signal has moved by a threshold."""
    reference = counts[0].astype(float)
    total = 0.0
    for row in counts[1:]:
        # [Cheng19 eq. 4, 5]: between two rows the signal is taken for straight
        steps = np.floor(np.abs(row - reference) / thresholds) * channels
        reference += np.sign(row - reference) * steps * thresholds
        total += float(steps.sum())
    return total


@dataclass(frozen=True)
class Packing:
    """One frame size in numbers.

    frames: for all events and for refreshing, every `REFRESH_STEPS`, what was not sent. refresh_frames: to say all nine
    values. repair_ms: mean time after a lost frame until the host has again a right value of what it carried.
    """

    frames: int
    refresh_frames: int
    repair_ms: float


def carries_whole(frame_bytes: int) -> bool:
    """Whether a frame of that size has room for all nine values, and so needs no mask."""
    return 8 * frame_bytes - FIXED_BITS >= CHANNEL_BITS.sum()


def frames_for(channels: Events, frame_bytes: int) -> int | None:
    """Frames that carry these values (9,) of one sample; None if a single value does not fit.

    A frame that has room for all channels needs no mask; a smaller one says in 9 bits which values it carries, and a
    sample with more values than fit takes several frames.
    """
    if not channels.any():
        return 0
    if carries_whole(frame_bytes):
        return 1
    room = 8 * frame_bytes - FIXED_BITS - MASK_BITS
    gaps: list[int] = []  # left in each frame, filled with the greatest values first
    for bits in sorted(map(int, CHANNEL_BITS[channels]), reverse=True):
        if bits > room:
            return None
        fitting = [index for index, gap in enumerate(gaps) if gap >= bits]
        if fitting:
            gaps[fitting[0]] -= bits
        else:
            gaps.append(room - bits)
    return len(gaps)


def pack(counts: Counts, channels: Events, sizes: list[int]) -> dict[int, Packing]:
    """What each frame size (bytes) costs under these samples; without the sizes too small for a value."""
    packings = {}
    kinds = {
        whole: _sendings(send_on_delta(counts, THRESHOLDS, channels, whole), channels, whole) for whole in (False, True)
    }
    for size in sizes:
        combinations, repair_ms = kinds[carries_whole(size)]
        refresh_frames = frames_for(np.ones(MASK_BITS, dtype=bool), size)
        if refresh_frames is None:
            continue
        used = np.flatnonzero(combinations)
        frames = sum(
            int(combinations[code]) * (frames_for(np.array([code >> c & 1 for c in range(9)], bool), size) or 0)
            for code in used
        )
        packings[size] = Packing(frames, refresh_frames, repair_ms)
    return packings


def _sendings(events: Events, channels: Events, whole: bool) -> tuple[NDArray[np.int64], float]:
    """How often each combination of channels is sent, by the bits of its code; mean repair time in milliseconds."""
    sent = np.repeat(events.any(axis=2, keepdims=True), events.shape[2], axis=2) if whole else events.copy()
    for start in range(0, len(events), REFRESH_STEPS):
        window = sent[start : start + REFRESH_STEPS]
        if len(window) == REFRESH_STEPS:
            window[-1] |= ~window.any(axis=0)
    weights = 1 << np.arange(events.shape[2])
    combinations = np.bincount((sent @ weights).ravel(), minlength=1 << events.shape[2])
    combinations[0] = 0
    next_sent = np.full(sent.shape[1:], np.inf)
    waits, lost = 0.0, 0
    for k in reversed(range(len(sent))):
        carried = sent[k] & channels & np.isfinite(next_sent) & events[k].any(axis=1, keepdims=True)
        waits += float((next_sent[carried] - k).sum())
        lost += int(carried.sum())
        next_sent = np.where(sent[k], k, next_sent)
    return combinations, waits / lost if lost else np.nan
