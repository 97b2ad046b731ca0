"""Events computed off-line from recorded samples: by the ideal sensor, by send-on-delta, and cut into packets."""

from collections.abc import Callable

import numpy as np
from numpy.typing import NDArray

from robotskin._core import firmware
from robotskin.world import World

CHANNEL_BITS = np.array([bits for _, _, bits, _, _ in firmware.CHANNELS])
THRESHOLDS = np.array([counts for _, counts in firmware.EVENT_THRESHOLDS])
"""Counts, the firmware's default: the published second standard set."""
FIXED_BITS = 8 * firmware.FRAME_BYTES - int(CHANNEL_BITS.sum())
"""Type, source, sequence, hops left, time, flags and checksum of a sample frame."""
MASK_BITS = len(CHANNEL_BITS)

Counts = NDArray[np.int32]


def record(world: World, drive: Callable[[float], None], seconds: float) -> Counts:
    """(T, N, 9) counts of all cells, sampled each millisecond, while `drive(time_s)` stimulates."""
    rows = []
    for step in range(round(1000 * seconds)):
        drive(world.time_s)
        world.step(0.001)
        rows.append(world.body.sample_all(step * 1_000_000))
    return np.array(rows)


def send_on_delta(counts: Counts, thresholds: NDArray[np.float64], channels: NDArray[np.bool_]) -> NDArray[np.bool_]:
    """(T, N, 9) which channels make an event at which sample (eq. 6, 7, Algorithm 1), each with its own reference."""
    reference = counts[0].astype(float)
    events = np.zeros(counts.shape, dtype=bool)
    for k in range(1, len(counts)):
        events[k] = (np.abs(counts[k] - reference) >= thresholds) & channels
        reference = np.where(events[k], counts[k], reference)
    return events


def ideal_events(counts: Counts, thresholds: NDArray[np.float64], channels: NDArray[np.bool_]) -> float:
    """Events of the ideal, unsampled sensor (eq. 4 and 5): one at each moment the signal has moved by a threshold."""
    reference = counts[0].astype(float)
    total = 0.0
    for row in counts[1:]:
        steps = np.floor(np.abs(row - reference) / thresholds) * channels
        reference += np.sign(row - reference) * steps * thresholds
        total += float(steps.sum())
    return total


def packets(events: NDArray[np.bool_], frame_bytes: int) -> int | None:
    """How many frames of a size carry these events; None if a single value does not fit.

    A frame that has room for all channels needs no mask; a smaller one says in 9 bits which values it carries, and a
    sample with more values than fit takes several frames.
    """
    room = 8 * frame_bytes - FIXED_BITS
    combinations, times = np.unique(events.reshape(-1, events.shape[-1]), axis=0, return_counts=True)
    total = 0
    for combination, count in zip(combinations, times, strict=True):
        if not combination.any():
            continue
        if room >= CHANNEL_BITS.sum():
            total += int(count)
            continue
        frames, left = 0, 0
        for bits in sorted(CHANNEL_BITS[combination], reverse=True):
            if bits > room - MASK_BITS:
                return None
            if bits > left:
                frames, left = frames + 1, room - MASK_BITS
            left -= int(bits)
        total += frames * int(count)
    return total
