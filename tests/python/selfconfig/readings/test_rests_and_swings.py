# SPDX-License-Identifier: Apache-2.0
"""A table of joints and accelerations over time, of sensors at unknown places, is enough to configure from."""

from dataclasses import replace

import numpy as np
import pytest

from robotskin.layout import Layout, finished
from robotskin.robots import Robot, load
from robotskin.robots.free_space import FreeSpace
from robotskin.selfconfig.babbling.plan import plan_babbling
from robotskin.selfconfig.configure import configure
from robotskin.selfconfig.readings.felt_series import FeltSeries
from robotskin.selfconfig.readings.neighbour_files import load_neighbours, save_neighbours
from robotskin.selfconfig.readings.recording import BabblingRecording, RecordingError
from robotskin.selfconfig.readings.rests_and_swings import recording_of
from robotskin.selfconfig.simulated.recording import simulate_babbling

HOME = np.array([0.0, -1.2, 1.0, -0.8, -1.0, 0.3])
STEP_S = 0.004
LATE_S = 0.006


@pytest.fixture(scope="module")
def ur5() -> Robot:
    return load("ur5")


@pytest.fixture(scope="module")
def cells() -> tuple[int, ...]:
    layout = finished("ur5")
    links = ("upper_arm_link", "forearm_link", "wrist_1_link", "wrist_2_link")
    return tuple(int(cell) for name in links for cell in layout.cells_on(name)[:12:4])


@pytest.fixture(scope="module")
def babbled(ur5, pytestconfig) -> tuple[Layout, BabblingRecording]:
    layout, random = finished("ur5"), np.random.default_rng(pytestconfig.getoption("--seed"))
    return layout, simulate_babbling(ur5, layout, plan_babbling(FreeSpace(ur5), HOME, random), random)


@pytest.fixture(scope="module")
def series(ur5, babbled, cells, pytestconfig) -> FeltSeries:
    """The babbling as a table: ways on which all joints move, rests, swings; sensors late, encoders with steps."""
    _, recording = babbled
    random, rows, chosen = np.random.default_rng([pytestconfig.getoption("--seed"), 1]), [], list(cells)
    at = HOME

    def way_to(posture: np.ndarray) -> None:
        nonlocal at
        s = np.linspace(0.0, 1.0, 300)[:, None]
        way = at + (posture - at) * (s * s * s * (10 - 15 * s + 6 * s * s))
        rows.append((way, random.normal(0.0, 3.0, (len(chosen), len(way), 3))))
        at = posture

    for number, posture in enumerate(recording.rest_posture):
        way_to(posture)
        felt = np.repeat(recording.rest_acceleration[chosen, number], 6, axis=1)
        rows.append((np.tile(posture, (felt.shape[1], 1)), felt))
    for swing in recording.swings:
        way_to(swing.swing.centre)
        still = np.repeat(swing.acceleration[chosen, :1], 60, axis=1)
        rows.append((np.tile(at, (60, 1)), still))
        rows.append((swing.swing.posture(swing.time_s), swing.acceleration[chosen]))
        rows.append((np.tile(at, (60, 1)), still))
    position = np.concatenate([way for way, _ in rows])
    step = 2 * np.pi / 2**17
    position = np.round(position / step) * step
    time_s = STEP_S * np.arange(len(position))
    early = np.column_stack([np.interp(time_s + LATE_S, time_s, column) for column in position.T])
    felt = np.concatenate([one for _, one in rows], axis=1).swapaxes(0, 1)
    return FeltSeries(ur5.joint_names, tuple(f"imu_{cell}" for cell in chosen), time_s, early, felt)


def test_a_table_comes_back_as_it_was(series: FeltSeries, tmp_path) -> None:
    holed = replace(series, acceleration=series.acceleration.copy())
    holed.acceleration[3, 1] = np.nan
    holed.save(tmp_path / "felt.csv")
    again = FeltSeries.load(tmp_path / "felt.csv", series.joint_names)
    assert again.sensor_names == series.sensor_names
    assert np.allclose(again.acceleration, holed.acceleration, atol=6e-4, equal_nan=True)
    assert np.allclose(again.position, series.position, atol=1e-6)


def test_rests_and_motions_of_single_joints_are_found(series: FeltSeries, babbled) -> None:
    _, recording = babbled
    found = recording_of(series, "ur5")
    assert len(found.rest_posture) >= len(recording.rest_posture)
    for posture in recording.rest_posture:
        assert np.abs(found.rest_posture - posture).max(axis=1).min() < 1e-3
    assert sorted(one.swing.joint for one in found.swings) == sorted(one.swing.joint for one in recording.swings)
    true = {(one.swing.joint, tuple(np.round(one.swing.centre, 2))) for one in recording.swings}
    told = {(one.swing.joint, tuple(np.round(one.swing.centre, 2))) for one in found.swings}
    assert len(true & told) >= 0.8 * len(true)


def test_sensors_at_unknown_places_are_placed_with_their_uncertainty(ur5, series, babbled, cells) -> None:
    layout, _ = babbled
    found = configure(
        ur5, recording_of(series, "ur5"), steps=("topology", "activity", "reconstruction", "localisation")
    )
    assert found.placed().all()
    errors_mm, sigmas_mm = [], []
    for patch in found.patches:
        cell = cells[int(found.topology.cell[patch.cells[0]]) - 1]
        assert patch.localisation is not None
        assert patch.localisation.link == layout.links[layout.link[cell]]
        apart = patch.link_from_cell()[0, :3, 3] - layout.link_from_cell[cell, :3, 3]
        errors_mm.append(1e3 * float(np.linalg.norm(apart)))
        sigmas_mm.append(1e3 * patch.localisation.deviation()[1])
    assert np.median(errors_mm) < 6.0
    assert (np.array(errors_mm) < 4 * np.array(sigmas_mm)).mean() > 0.8


def test_neighbours_are_read_where_they_are_known(babbled, tmp_path) -> None:
    _, recording = babbled
    save_neighbours(recording.lists, tmp_path / "plugs.csv")
    again = load_neighbours(tmp_path / "plugs.csv", recording.lists.cell)
    facing = recording.lists.faces_cell()
    assert np.array_equal(again.neighbour[facing], recording.lists.neighbour[facing])
    assert not again.faces_cell()[~facing].any()
    (tmp_path / "wrong.csv").write_text("cell,port,neighbour,neighbour_port\n7777777,1,1,1\n")
    with pytest.raises(RecordingError, match=r"wrong.csv, line 2: cell 7777777"):
        load_neighbours(tmp_path / "wrong.csv", recording.lists.cell)


@pytest.mark.parametrize(
    ("heading", "row", "said"),
    [
        ("time_s,elbow_joint,a_x,a_y,a_z", "0,0,0,0,0", "no column shoulder_pan_joint"),
        ("time_s,JOINTS,a_x,a_y", "0,0,0,0,0,0,0,0,0", "a_z"),
        ("time_s,JOINTS,a_x,a_y,a_z", "nan,0,0,0,0,0,0,0,0,0", "line 2: time_s"),
        ("time_s,JOINTS,a_x,a_y,a_z", "0,,0,0,0,0,0,0,0,0", "line 2: shoulder_pan_joint"),
        ("time_s,JOINTS,a_x,a_y,a_z", "0,0,0,0,0,0,0,0,0,up", "up"),
    ],
)
def test_other_tables_are_refused(ur5, tmp_path, heading: str, row: str, said: str) -> None:
    file = tmp_path / "felt.csv"
    file.write_text(f"{heading.replace('JOINTS', ','.join(ur5.joint_names))}\n{row}\n")
    with pytest.raises(RecordingError, match=said):
        FeltSeries.load(file, ur5.joint_names)


def test_a_robot_that_stands_tells_too_little(series: FeltSeries) -> None:
    still = FeltSeries(
        series.joint_names, series.sensor_names, series.time_s, np.zeros_like(series.position), series.acceleration
    )
    with pytest.raises(RecordingError, match="0 motions of single joints"):
        recording_of(still, "ur5")
