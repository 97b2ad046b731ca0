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
from robotskin.selfconfig.topology.neighbours import NeighbourLists

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


def lag_s(series: FeltSeries) -> float:
    return -float(recording_of(series, "ur5").swings[0].time_s[0])


def with_holes(series: FeltSeries, which: str, seed: int) -> FeltSeries:
    random, felt = np.random.default_rng([seed, 2]), series.acceleration.copy()
    if which in ("few", "most"):
        felt[random.random(felt.shape[:2]) < {"few": 0.01, "most": 0.6}[which]] = np.nan
    elif which == "alternate rows":
        for sensor in range(felt.shape[1]):
            felt[sensor % 2 :: 2, sensor] = np.nan
    elif which == "all but one sensor":
        felt[:, np.arange(felt.shape[1]) != 9] = np.nan
    return replace(series, acceleration=felt)


@pytest.mark.parametrize("holes", ["none", "few", "most", "alternate rows", "all but one sensor"])
def test_how_late_sensors_are_is_found_from_whatever_readings_there_are(series, holes: str, seed: int) -> None:
    assert lag_s(with_holes(series, holes, seed)) == pytest.approx(LATE_S, abs=1e-3)


@pytest.mark.parametrize("late_s", [-0.036, 0.036])
def test_a_lag_within_the_bound_is_found_and_one_beyond_it_is_refused(series: FeltSeries, late_s: float) -> None:
    def shifted(by_s: float) -> FeltSeries:
        columns = [np.interp(series.time_s + by_s, series.time_s, column) for column in series.position.T]
        return replace(series, position=np.column_stack(columns))

    assert lag_s(shifted(late_s - LATE_S)) == pytest.approx(late_s, abs=1e-3)
    with pytest.raises(RecordingError, match=f"{'later' if late_s > 0 else 'earlier'} than the joints by more than 40"):
        lag_s(shifted(2 * late_s - LATE_S))


def test_where_no_lag_can_be_told_the_series_is_refused(series: FeltSeries, seed: int) -> None:
    moving = np.abs(np.gradient(series.position, axis=0)).max(axis=1) > 1e-5
    unread = series.acceleration.copy()
    unread[moving] = np.nan
    with pytest.raises(RecordingError, match=r"sensors imu_\d+.* and \d+ more: none has 20 readings in any motion"):
        recording_of(replace(series, acceleration=unread), "ur5")
    unmoved = np.random.default_rng(seed).normal([0.0, 0.0, 9.81], 0.1, series.acceleration.shape)
    with pytest.raises(RecordingError, match="does not answer the motions of the joints"):
        recording_of(replace(series, acceleration=unmoved), "ur5")


@pytest.mark.parametrize("unit_mps2", [9.80665, 9.80665e-3, 0.01])
def test_a_sensor_that_reads_no_gravity_at_rest_is_refused_by_its_name(series: FeltSeries, unit_mps2: float) -> None:
    felt = series.acceleration.copy()
    felt[:, 4] /= unit_mps2
    name = series.sensor_names[4]
    with pytest.raises(RecordingError, match=rf"sensor {name} reads [\d.e+]+ at rest, where gravity is 9.81 m/s²"):
        recording_of(replace(series, acceleration=felt), "ur5")


@pytest.mark.parametrize("rows", [0, 1, 3])
def test_a_few_instants_are_no_series(series: FeltSeries, rows: int) -> None:
    short = replace(
        series, time_s=series.time_s[:rows], position=series.position[:rows], acceleration=series.acceleration[:rows]
    )
    with pytest.raises(RecordingError, match=f"{rows} instants"):
        recording_of(short, "ur5")


@pytest.mark.parametrize("holes", ["none", "few", "alternate rows"])
def test_sensors_at_unknown_places_are_placed_with_their_uncertainty(
    ur5, series, babbled, cells, holes: str, seed: int
) -> None:
    layout, _ = babbled
    recording = recording_of(with_holes(series, holes, seed), "ur5")
    found = configure(ur5, recording, steps=("topology", "activity", "reconstruction", "localisation"))
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


def test_a_port_that_the_network_does_not_tell_comes_back_untold(tmp_path) -> None:
    keys, none = np.array([1, 2]), [0, 0, 0, 0]
    save_neighbours(NeighbourLists(keys, [[2, 0, 0, 0], none], [none, none]), tmp_path / "plugs.csv")
    again = load_neighbours(tmp_path / "plugs.csv", keys)
    assert again.neighbour.tolist() == [[2, 0, 0, 0], none]
    assert again.port.tolist() == [none, none]


@pytest.mark.parametrize(
    ("rows", "said"),
    [
        ("7777777,1,1,1", "line 2: cell 7777777 is no sensor; they are 1, 2, 3"),
        ("1,1.7,2,1", "line 2: port: 1.7: must be a port, 1 to 4"),
        ("1,5,2,1", "line 2: port: 5: must be a port"),
        ("1,1,2,0", "line 2: neighbour_port: 0: must be a port"),
        ("1,,2,1", "line 2: port: nan: must be a port"),
        ("1,1,2,1\n2,1,1.5,1", "line 3: neighbour: 1.5: must be a whole number"),
        ("1,1,2,1\n1,2,left,1", "line 3: neighbour: left: must be a finite number"),
        ("1,1,2,1\n1,1,3,1", "line 3: port 1 of cell 1 has a plug already, in line 2"),
        ("1,1,2", "line 2: 3 cells, where the heading has 4"),
    ],
)
def test_plugs_that_cannot_be_are_refused_by_line_and_column(tmp_path, rows: str, said: str) -> None:
    (tmp_path / "wrong.csv").write_text(f"cell,port,neighbour,neighbour_port\n{rows}\n")
    with pytest.raises(RecordingError, match=f"wrong.csv, {said}"):
        load_neighbours(tmp_path / "wrong.csv", np.array([1, 2, 3]))


def test_a_table_without_plugs_is_refused_with_its_columns(tmp_path) -> None:
    (tmp_path / "wrong.csv").write_text("cell,port,neighbour\n1,1,2\n")
    with pytest.raises(RecordingError, match="no column neighbour_port; the columns are cell, port"):
        load_neighbours(tmp_path / "wrong.csv", np.array([1, 2, 3]))


@pytest.mark.parametrize(
    ("heading", "row", "said"),
    [
        ("time_s,elbow_joint,a_x,a_y,a_z", "0,0,0,0,0", "no column shoulder_pan_joint"),
        ("time_s,JOINTS,a_x,a_y", "0,0,0,0,0,0,0,0,0", "a_z"),
        ("time_s,JOINTS,a_x,a_y,a_z", "nan,0,0,0,0,0,0,0,0,0", "line 2: time_s"),
        ("time_s,JOINTS,a_x,a_y,a_z", "0,,0,0,0,0,0,0,0,0", "line 2: shoulder_pan_joint"),
        ("time_s,JOINTS,a_x,a_y,a_z", "0,0,0,0,0,0,0,0,0,up", "line 2: a_z: up: must be a finite number, or empty"),
        ("time_s,JOINTS,a_x,a_y,a_z", "0,0,0,0,0,0,0,0,inf,0", "line 2: a_y: inf"),
        ("time_s,JOINTS,a_x,a_y,a_z", "0,0,0,0,0,0,0,0,N/A,0", "line 2: a_y: N/A"),
        ("time_s,JOINTS,a_x,a_y,a_z", "0,0,0,0,0,0,0,0,null,0", "line 2: a_y: null"),
        ("time_s,JOINTS,a_x,a_y,a_z,a_x", "0,0,0,0,0,0,0,0,0,9,0", "felt.csv: column a_x stands twice"),
        ("", "", "felt.csv: is empty; its first line names the columns"),
        ("time_s,JOINTS,a_x,a_y,a_z", "0,0,0,0,0,0,0,True,0,0", "line 2: a_x: True"),
        ("time_s,JOINTS,a_x,a_y,a_z", "0,0,0,0,0,0,0,0,0", "line 2: 9 cells, where the heading has 10"),
        ("time_s,JOINTS,a_x,a_y,a_z", "0,0,0,0,0,0,0,0,0,9,8", "line 2: 11 cells, where the heading has 10"),
        ("time_s,JOINTS,a_x,a_y,a_z", "0,0,0,0,0,0,0,0,0,9\n\n0.01,0,0,0,0,0,0,0,0,9.8.1", "line 4: a_z: 9.8.1"),
        ("time_s,JOINTS,a_x,a_y,a_z", "0,0,0,0,0,0,0,0,0,9\n0,0,0,0,0,0,0,0,0,9", "line 3: time_s: 0: must be .* rise"),
        ("time_s,JOINTS,a_x,a_y,a_z", "", "0 rows"),
        ("time_s,JOINTS,a_x,a_y,a_z", "0,0,0,0,0,0,0,0,0,9", "1 rows"),
        ("time_s,JOINTS,a_x,a_y,a_z", "0,0,0,0,0,0,0,0,0,9\n0.02,0,0,0,0,0,0,0,0,9", "time_s: steps of 20 ms .* 10 ms"),
    ],
)
def test_other_tables_are_refused(ur5, tmp_path, heading: str, row: str, said: str) -> None:
    file = tmp_path / "felt.csv"
    file.write_text(f"{heading.replace('JOINTS', ','.join(ur5.joint_names))}\n{row}\n")
    with pytest.raises(RecordingError, match=said):
        FeltSeries.load(file, ur5.joint_names)


def test_a_table_that_is_no_text_is_refused_by_its_name(ur5, tmp_path) -> None:
    file = tmp_path / "felt.csv"
    file.write_bytes(b"time_s\xff\xfe\n0\n")
    with pytest.raises(RecordingError, match=r"felt\.csv: is no text in UTF-8"):
        FeltSeries.load(file, ur5.joint_names)


def test_a_robot_that_stands_tells_too_little(series: FeltSeries) -> None:
    still = FeltSeries(
        series.joint_names, series.sensor_names, series.time_s, np.zeros_like(series.position), series.acceleration
    )
    with pytest.raises(RecordingError, match="0 motions of single joints"):
        recording_of(still, "ur5")
