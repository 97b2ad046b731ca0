from pathlib import Path

import numpy as np
import pytest

from robotskin.selfconfig.babbling.joint_sine import JointSine
from robotskin.selfconfig.common.gravity import ACCELERATION_STEP_MPS2
from robotskin.selfconfig.readings.motion_recording import MotionRecording
from robotskin.selfconfig.readings.recording import BabblingRecording, RecordingError, joined
from robotskin.selfconfig.topology.neighbours import NeighbourLists


def drawn(seed: int, cells: int = 5, rests: int = 3) -> BabblingRecording:
    random = np.random.default_rng(seed)

    def readings(*shape: int) -> np.ndarray:
        felt = random.integers(-500, 500, shape) * ACCELERATION_STEP_MPS2
        felt[random.random(shape[:-1]) < 0.1] = np.nan
        return felt

    lists = NeighbourLists(1 << 16 | np.arange(1, cells + 1), random.integers(0, 9, (cells, 4)), np.ones((cells, 4)))
    swings = tuple(
        MotionRecording(
            JointSine(joint, random.uniform(-1, 1, 2), 0.1, 1.0, 2.0), np.arange(7) / 250, readings(cells, 7, 3)
        )
        for joint in (1, 0, 1)
    )
    return BabblingRecording(
        "arm", ("a", "b"), lists, np.array([[1, 2, 0, 3]]), random.uniform(-1, 1, (rests, 2)),
        readings(cells, rests, 4, 3), swings, 12.5,
    )  # fmt: skip


def same(one: BabblingRecording, other: BabblingRecording) -> bool:
    parts = [
        (one.lists.cell, other.lists.cell),
        (one.lists.neighbour, other.lists.neighbour),
        (one.lists.port, other.lists.port),
        (one.unit_ports, other.unit_ports),
        (one.rest_posture, other.rest_posture),
        (one.rest_acceleration, other.rest_acceleration),
    ]
    for a, b in zip(one.swings, other.swings, strict=True):
        parts += [(a.time_s, b.time_s), (a.acceleration, b.acceleration), (a.swing.centre, b.swing.centre)]
        parts.append((a.swing.posture(a.time_s), b.swing.posture(a.time_s)))
    named = (one.robot, one.joint_names, one.duration_s) == (other.robot, other.joint_names, other.duration_s)
    return named and all(np.allclose(a, b, atol=1e-12, equal_nan=True) for a, b in parts)


def test_a_recording_comes_back_as_it_was_saved(tmp_path: Path, seed: int) -> None:
    recording = drawn(seed)
    recording.save(tmp_path / "felt.npz")
    assert same(BabblingRecording.load(tmp_path / "felt.npz"), recording)
    assert [path.name for path in tmp_path.iterdir()] == ["felt.npz"]


def test_what_is_no_recording_is_refused_by_name(tmp_path: Path, seed: int) -> None:
    text = tmp_path / "text.npz"
    text.write_text("no archive")
    with pytest.raises(RecordingError, match=r"text\.npz"):
        BabblingRecording.load(text)
    foreign = tmp_path / "foreign.npz"
    np.savez(foreign, format="something else")
    with pytest.raises(RecordingError, match="something else"):
        BabblingRecording.load(foreign)
    whole = tmp_path / "whole.npz"
    drawn(seed).save(whole)
    with np.load(whole) as archive:
        arrays = dict(archive)
    del arrays["rest_posture"]
    np.savez(whole, **arrays)
    with pytest.raises(RecordingError, match="rest_posture"):
        BabblingRecording.load(whole)
    arrays["rest_posture"] = np.zeros((2, 2))
    np.savez(whole, **arrays)
    with pytest.raises(RecordingError, match="rest_acceleration"):
        BabblingRecording.load(whole)


def test_recordings_of_the_same_cells_are_joined_and_others_are_not(seed: int) -> None:
    one, two = drawn(seed), drawn(seed + 1)
    both = joined([one, two])
    assert len(both.rest_posture) == 6
    assert len(both.swings) == 6
    assert np.array_equal(both.rest_acceleration[:, 3:], two.rest_acceleration, equal_nan=True)
    with pytest.raises(RecordingError, match="cells"):
        joined([one, drawn(seed, cells=6)])
    with pytest.raises(RecordingError, match="no recordings"):
        joined([])
