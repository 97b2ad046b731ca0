# SPDX-License-Identifier: Apache-2.0
from dataclasses import replace
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
            JointSine(joint, random.uniform(-1, 1, 2), 0.1, 1.0, 2.0),
            np.arange(7) / 250,
            readings(cells, 7, 3),
            posture,
        )
        for joint, posture in ((1, None), (0, random.uniform(-1, 1, (7, 2))), (1, None))
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
        assert (a.posture is None) == (b.posture is None)
        parts += [] if a.posture is None else [(a.posture, b.posture)]
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


def test_a_damaged_file_is_refused_by_name(tmp_path: Path, seed: int) -> None:
    """Cut anywhere, or with any byte changed, a file is either refused by its name or reads as it was."""
    whole, damaged = tmp_path / "whole.npz", tmp_path / "damaged.npz"
    recording = drawn(seed)
    recording.save(whole)
    data, random = whole.read_bytes(), np.random.default_rng(seed)
    for length in random.integers(0, len(data), 20):
        damaged.write_bytes(data[:length])
        with pytest.raises(RecordingError, match=r"damaged\.npz"):
            BabblingRecording.load(damaged)
    refused: list[str] = []
    for at in random.integers(0, len(data), 60):
        damaged.write_bytes(data[:at] + bytes([data[at] ^ 0x55]) + data[at + 1 :])
        try:
            assert same(BabblingRecording.load(damaged), recording)
        except RecordingError as error:
            refused.append(str(error))
    assert len(refused) > 30
    assert all("damaged.npz" in message for message in refused)
    np.save(tmp_path / "single.npy", np.zeros(3))
    with pytest.raises(RecordingError, match=r"single\.npy"):
        BabblingRecording.load(tmp_path / "single.npy")
    with pytest.raises(RecordingError, match=r"nowhere\.npz"):
        BabblingRecording.load(tmp_path / "nowhere.npz")


@pytest.mark.parametrize(
    ("array", "at", "value"),
    [
        ("version", (), "new"),
        ("cell", 1, (1 << 16) + 1),
        ("rest_posture", (0, 0), np.nan),
        ("swing_centre", (1, 1), np.inf),
        ("swing_motion", (0, 1), 0.0),
        ("swing_joint", 2, 5),
        ("swing_1_time", 3, np.nan),
        ("unit_ports", (0, 2), 5),
        ("unit_ports", (0, 3), 0),
    ],
)
def test_values_that_cannot_be_are_refused_by_name(
    tmp_path: Path, seed: int, array: str, at: object, value: object
) -> None:
    path = tmp_path / "felt.npz"
    drawn(seed).save(path)
    with np.load(path) as archive:
        arrays = dict(archive)
    if at == ():
        arrays[array] = np.array(value)
    else:
        arrays[array][at] = value
    np.savez(path, **arrays)
    name = "swing [012]" if array.startswith("swing") else array
    with pytest.raises(RecordingError, match=rf"felt\.npz.*{name}"):
        BabblingRecording.load(path)


def test_a_recording_has_cells_and_its_swings_readings(seed: int) -> None:
    recording = drawn(seed)
    swing = recording.swings[1]
    bare = replace(swing, time_s=swing.time_s[:0], acceleration=swing.acceleration[:, :0])
    with pytest.raises(RecordingError, match="swing 1 time: 0: must be two"):
        replace(recording, swings=(recording.swings[0], bare))
    nothing = NeighbourLists(np.zeros(0), np.zeros((0, 4)))
    with pytest.raises(RecordingError, match="cell: none"):
        replace(
            recording,
            lists=nothing,
            unit_ports=np.zeros((0, 4), dtype=np.int64),
            rest_acceleration=recording.rest_acceleration[:0],
            swings=(),
        )


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
