# SPDX-License-Identifier: Apache-2.0
"""The benchmark of event mode, in short: its laws, on random streams and on the real thing."""

from pathlib import Path

import numpy as np
import pytest

from robotskin import robots
from robotskin.layout import finished
from robotskin_lab.bench import events
from robotskin_lab.bench.event_predictors import PREDICTORS, REFRESH_STEPS, frames_sent
from robotskin_lab.bench.event_rig import Rig
from robotskin_lab.bench.event_streams import (
    CHANNEL_BITS,
    FIXED_BITS,
    MASK_BITS,
    THRESHOLDS,
    carries_whole,
    frames_for,
    ideal_events,
    pack,
    send_on_delta,
)
from robotskin_lab.bench.stimulus import places
from robotskin_lab.reproduce.result import load

ALL = np.ones(9, dtype=bool)


@pytest.fixture
def stream(seed: int) -> np.ndarray:
    """(1000, 12, 9) counts that wander."""
    steps = np.random.default_rng(seed).normal(0, 0.3 * THRESHOLDS, (1000, 12, 9))
    return np.cumsum(steps, axis=0).round().astype(np.int32)


@pytest.mark.parametrize("whole", [False, True])
def test_the_host_is_never_wrong_by_a_threshold(stream, whole):
    sent = send_on_delta(stream, THRESHOLDS, ALL, whole)
    if whole:
        sent[:] = sent.any(axis=2, keepdims=True)
    held = stream[0].copy()
    for k in range(1, len(stream)):
        held = np.where(sent[k], stream[k], held)
        assert (np.abs(held - stream[k]) < THRESHOLDS).all()


def test_the_ideal_sensor_makes_at_least_the_events_of_a_sampled_one(stream):
    """Of a signal that only rises each event uses up a threshold, and the ideal sensor wastes nothing."""
    rising = np.cumsum(np.abs(np.diff(stream, axis=0)), axis=0).astype(np.int32)
    for scale in (0.5, 1.0, 4.0):
        ideal = ideal_events(rising, THRESHOLDS * scale, ALL)
        assert ideal == pytest.approx(((rising[-1] - rising[0]) / (THRESHOLDS * scale)).astype(int).sum(), rel=1e-3)
        assert ideal >= send_on_delta(rising, THRESHOLDS * scale, ALL).sum() > 0


def test_frames_have_room_for_what_they_carry(seed):
    random = np.random.default_rng(seed)
    for size in range(9, 33):
        for _ in range(20):
            channels = random.random(9) < 0.5
            frames = frames_for(channels, size)
            if frames is None:
                assert CHANNEL_BITS[channels].max() > 8 * size - FIXED_BITS - MASK_BITS
            else:
                mask = 0 if carries_whole(size) else MASK_BITS
                assert frames * (8 * size - FIXED_BITS - mask) >= CHANNEL_BITS[channels].sum()
                assert (frames == 0) == (not channels.any())
    assert frames_for(ALL, 20) == 1
    assert not carries_whole(19)


def test_whole_frames_repair_sooner_than_masked_ones(stream):
    packings = pack(stream, ALL, [8, 14, 20])
    assert set(packings) == {14, 20}, "proximity does not fit beside 71 other bits into 8 bytes"
    assert packings[20].repair_ms < packings[14].repair_ms <= 250
    assert packings[20].refresh_frames == 1 < packings[14].refresh_frames
    refreshes = len(stream) / 250 * stream.shape[1]
    assert packings[14].frames >= refreshes * packings[14].refresh_frames / 9


def test_palms_lie_apart(seed):
    layout = finished("ur5")
    poses = layout.link_from_cell.copy()
    poses[:, :3, 3] += 2.0 * layout.link[:, None]  # links out of each other's way
    chosen = places(poses, 100)
    centres = poses[chosen, :3, 3] + 0.05 * poses[chosen, :3, 2]
    gaps = np.linalg.norm(centres[:, None] - centres[None], axis=2)[np.triu_indices(len(chosen), 1)]
    assert len(chosen) > 5
    assert gaps.min() >= 0.1


def test_a_robot_at_rest_is_quiet_and_a_held_one_talks(seed):
    rig = Rig(robots.load("ur5"), finished("ur5"), seed, 60)
    rig.set_mode(True, events.TOUCH_EVENT_MASK)
    idle = rig.measure(0.5)
    touch = rig.touch(1.0)
    held = rig.measure(0.5, touch)
    assert idle.cells_active == 0
    assert held.cells_active > 40
    fresh = [260 * 1000 / steps for steps in (1.2 * REFRESH_STEPS, REFRESH_STEPS)]  # with the jitter, and without
    assert 0.9 * fresh[0] < idle.frames_per_s < 1.15 * fresh[1], "nothing speaks but to show that it lives"
    assert idle.frames_per_s < held.frames_per_s < 1000 * 260
    assert idle.bytes_per_s < held.bytes_per_s


def test_packet_sizes_and_ideal_sensor_are_reported_and_drawn(seed, tmp_path):
    figures = events.off_line(robots.load("ur5"), finished("ur5"), seed, 0.5, str(tmp_path))
    assert figures["ideal_events_per_s"] >= figures["sampled_events_per_s"] > 0
    assert figures["packet_20_refresh_frames"] == 1
    assert figures["packet_20_repair_ms_all"] <= 250
    assert all(np.isfinite(value) for value in figures.values())
    for name in ("packet_size", "ideal_event_sensor"):
        assert (tmp_path / f"{name}.svg").stat().st_size > 1000


def test_every_predictor_keeps_the_error_bound(seed: int) -> None:
    """Of noisy steps and ramps; and on a straight ramp without noise a line needs hardly a frame."""
    random = np.random.default_rng(seed)
    steps, cells = 400, 6
    ramp = np.arange(steps)[:, None] * np.array([0, 0.5, 1, 2, -1, 3])
    counts = np.zeros((steps, cells, 9), dtype=np.int32)
    counts[:, :, :4] = np.rint(ramp[:, :, None] + random.normal(0, 1.2, (steps, cells, 4)))
    counts[steps // 2 :, :3] += 30
    for name, made in PREDICTORS.items():
        frames, violations = frames_sent(counts, made)
        assert violations == 0, name
        assert frames >= cells * (steps - 1) // REFRESH_STEPS, name
    straight = np.zeros((steps, 1, 9), dtype=np.int32)
    straight[:, 0, 1] = 2 * np.arange(steps)
    assert 5 * frames_sent(straight, PREDICTORS["linear"])[0] < frames_sent(straight, PREDICTORS["hold"])[0]


def test_the_page_cites_what_was_counted_of_each_way() -> None:
    page = (Path(__file__).parents[3] / "docs/protocol.md").read_text(encoding="utf-8")
    for name in PREDICTORS:
        assert f"| <!-- event_predictors.frames_per_s_{name} " in page, name
        assert load("event_predictors").worst({})[f"reconstruction_violations_{name}"] == 0
