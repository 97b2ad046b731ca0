# SPDX-License-Identifier: Apache-2.0
"""Calibrations find what sensors do, know how well, and are refused where they do not belong."""

import dataclasses
from pathlib import Path

import numpy as np
import pytest
from scipy.stats import chi2

from robotskin import robots
from robotskin.calibration import Calibration, CalibrationError, Known, Presses, ZeroWatch, calibrate, post
from robotskin.calibration.force_sensors import OFFSET, PARAMETERS, felt, shown
from robotskin.calibration.post import AtPost, Levers, postures_at_post
from robotskin.calibration.press_files import COLUMNS, read_presses
from robotskin.calibration.probing import probed
from robotskin.layout import finished
from robotskin.record import Recorder, Recording
from robotskin.robots.free_space import FreeSpace
from robotskin.robots.gains import gains_of, robot_with_gains
from robotskin.session import Session
from robotskin_lab.bench.calibration import TORQUE_NOISE_NM
from robotskin_lab.bench.calibration_rig import Rig

ROBOT, LAYOUT = robots.load("ur5"), finished("ur5")
HOME = np.array([0.0, -1.2, 1.5, -0.3, 1.0, 0.0])
CELLS = range(120, 250, 26)


def at_home() -> list[AtPost]:
    lever, at, _ = Levers(ROBOT, LAYOUT).at(HOME)
    return [AtPost(cell, HOME, lever[cell], at[cell]) for cell in CELLS]


def check(rig: Rig, calibration: Calibration) -> tuple[float, float, float]:
    """Error of forces with and without it, newton, and the mean of the squared errors of the parameters over theirs."""
    errors, without = [], []
    for cell in np.flatnonzero(calibration.calibrated):
        for force_n in (2.0, 9.0, 6.0):
            force = rig.pressed(cell, force_n, rig.draw.uniform(-0.006, 0.006, 2))
            reading = rig.read(force, 0.05)[cell]
            errors.append(felt(calibration.parameters[cell], reading).sum() - force[cell].sum())
            without.append(np.maximum(reading - rig.rest_n[cell], 0).sum() - force[cell].sum())
    known = calibration.calibrated
    error = (calibration.parameters - rig.true_parameters())[known]
    nees = np.einsum("ni,nij,nj->n", error, np.linalg.inv(calibration.covariance[known]), error)
    return float(np.std(errors)), float(np.std(without)), float(nees.mean() / PARAMETERS)


def test_a_probe_and_joint_torques_find_the_sensors_within_what_they_say(seed: int) -> None:
    rig = Rig(LAYOUT, seed)
    friction = rig.draw.uniform(-0.9, 0.9, ROBOT.joint_count)
    known = Known(friction_nm=(0.9 / np.sqrt(3),) * ROBOT.joint_count)
    for presses in (
        [rig.by_probe(cell) for cell in CELLS],
        [rig.by_torques(one, ROBOT, friction, TORQUE_NOISE_NM) for one in at_home()],
    ):
        error_n, without_n, nees = check(rig, calibrate(LAYOUT, presses, known, method="test"))
        assert error_n < 0.6 * without_n
        assert 0.4 < nees < chi2.ppf(0.9999, PARAMETERS) / PARAMETERS


def test_friction_and_levers_do_not_become_sure_by_pressing_more(seed: int) -> None:
    rig = Rig(LAYOUT, seed)
    one = rig.by_torques(at_home()[3], ROBOT, np.zeros(6), TORQUE_NOISE_NM)
    twice = dataclasses.replace(
        one,
        **{
            name: np.concatenate([getattr(one, name)] * 2)
            for name in ("reading_n", "place_m", "carried_n", "torque_nm", "lever_nm_per_n", "direction")
        },
    )
    known = Known(lever_share=0.05)
    total = np.zeros(PARAMETERS)
    total[:3] = 1 / 3
    for presses in (one, twice):
        found = calibrate(LAYOUT, [presses], known, method="test")
        assert np.sqrt(total @ found.covariance[one.cell] @ total) > 0.04


def test_what_is_shown_and_felt_are_each_others_reverse(seed: int) -> None:
    draw = np.random.default_rng(seed)
    parameters = np.concatenate(
        [draw.uniform(0.8, 1.2, (9, 3)), draw.uniform(0, 0.2, (9, 3)), draw.uniform(-0.05, 0.05, (9, 6))], axis=1
    )
    force = draw.uniform(0.5, 5, (9, 3))
    np.testing.assert_allclose(felt(parameters, shown(parameters, force)), force)
    assert (felt(parameters, np.zeros((9, 3))) == 0).all(), "a sensor at zero feels nothing, whatever its offset"


def drawn(seed: int) -> Calibration:
    draw = np.random.default_rng(seed)
    parameters = np.tile(np.array([1.0] * 3 + [0.0] * 9), (len(LAYOUT), 1))
    parameters[:, :3] = draw.uniform(0.8, 1.2, (len(LAYOUT), 3))
    parameters[:, OFFSET] = draw.uniform(-0.05, 0.1, (len(LAYOUT), 3))
    spread = draw.normal(0, 0.01, (len(LAYOUT), PARAMETERS, PARAMETERS))
    covariance = spread @ np.swapaxes(spread, 1, 2)
    calibrated = np.ones(len(LAYOUT), bool)
    return Calibration.of(LAYOUT, parameters, covariance, calibrated, date="2026-01-01", method="drawn")


def test_a_file_keeps_all_and_is_refused_for_another_skin_or_if_damaged(tmp_path: Path, seed: int) -> None:
    made = drawn(seed)
    made.save(tmp_path / "own.json")
    read = Calibration.load(tmp_path / "own.json")
    assert (read.parameters == made.parameters).all()
    np.testing.assert_allclose(read.covariance, made.covariance, rtol=1e-8)
    assert (read.date, read.method, read.share) == ("2026-01-01", "drawn", 1.0)
    with pytest.raises(CalibrationError, match=r"260 cells: this is panda.*robotskin calibrate"):
        read.applied(finished("panda"))
    text = (tmp_path / "own.json").read_text()
    for wrong in ("", "[]", "{}", text[: len(text) // 2], text.replace('"version": 1', '"version": 9'), "null"):
        (tmp_path / "bad.json").write_text(wrong)
        with pytest.raises(CalibrationError, match=r"bad\.json"):
            Calibration.load(tmp_path / "bad.json")


def test_a_session_feels_with_it_and_a_recording_replays_it_to_the_byte(tmp_path: Path, seed: int) -> None:
    made = drawn(seed)
    session = Session(ROBOT, made.applied(LAYOUT), seed=seed, link="in process")
    session.boot()
    states = []
    with Recorder(tmp_path / "touch.mcap", session):
        session.world.push(cell=135, force_n=12.0)
        for _ in range(150):
            session.step()
            states.append(np.asarray(session.skin.normal_force).copy())
    shown_n = np.asarray(session.reader.measured_force, dtype=float)
    expected = np.maximum(felt(made.parameters, shown_n) - np.asarray(session.reader.force_offset), 0)
    np.testing.assert_allclose(states[-1], expected, atol=2e-5)
    assert np.abs(states[-1] - shown_n)[135].max() > 0.02, "it makes a difference"
    session.shut_down()
    recording = Recording(tmp_path / "touch.mcap")
    assert (recording.layout.calibration.parameters == made.parameters).all()
    replayed = [np.asarray(frame.skin.normal_force).copy() for frame in recording.frames()]
    assert replayed[-1].tobytes() == states[-1].tobytes() or any(r.tobytes() == states[-1].tobytes() for r in replayed)


def test_a_simulated_probe_finds_what_the_sensors_of_the_world_have(tmp_path: Path, seed: int) -> None:
    robot = robot_with_gains("allegro_right_hand", None)
    layout = finished("allegro_right_hand")
    session = Session(robot.robot, layout, "skin_compliance", seed=seed, gains=robot.gains, link="in process")
    session.set_skin(False)
    session.boot()
    pressed = probed(session, np.random.default_rng(seed).permutation(len(layout))[:6].tolist())
    session.shut_down()
    assert pressed
    for one in pressed:
        above = (one.reading_n - one.rest_n).sum(axis=1)
        assert np.all(above > 0.5 * one.force_n)
    made = calibrate(layout, pressed, method="probe")
    made.save(tmp_path / "probed.json")
    assert (Calibration.load(tmp_path / "probed.json").calibrated == made.calibrated).all()
    off = np.abs(made.parameters[:, :3] - 1)
    unsure = np.sqrt(np.diagonal(made.covariance, axis1=1, axis2=2))[:, :3]
    assert np.all((off < 0.05 + 4 * unsure)[made.calibrated])
    assert np.median(off[made.calibrated]) < 0.05


def test_presses_that_fit_no_sensor_are_left_out() -> None:
    """A probe that stands on another cell half of the time, as one was seen to do."""
    place = np.repeat(0.006 * np.array([[0.0, 1.0], [-0.87, -0.5], [0.87, -0.5]]), 3, axis=0)
    above = [[0, 0, 0], [0, 0, 0], [0.88, 0.48, 0.5], [0.04, 0.05, 0.06], [0.02, 0.04, 0.04], [0.02, 0.03, 0.03],
             [1.95, 1.94, 3.6], [1.21, 1.21, 2.24], [0.47, 0.48, 0.89]]  # fmt: skip
    rest_n = np.array([0.22, 0.24, 0.14])
    nonsense = Presses(
        cell=231, neighbours=2, rest_n=rest_n, reading_n=rest_n + above,
        place_m=place, carried_n=np.full(9, np.nan), force_n=np.array([0, 0, 2.03, 7.76, 5.24, 2.37, 8.11, 5.0, 2.0]),
    )  # fmt: skip
    assert calibrate(LAYOUT, [nonsense], method="probe").share == 0.0


def test_zeros_are_followed_where_nothing_is_near_and_no_touch_is_taken_for_one(seed: int) -> None:
    made = drawn(seed)
    watch = ZeroWatch(made)
    draw = np.random.default_rng(seed)
    truth = made.parameters[:, OFFSET].copy()
    touched = np.arange(len(LAYOUT)) < 20
    for second in range(600):
        reading = truth + 0.15 * second / 600 + draw.normal(0, 0.01, truth.shape)
        reading[touched] += 0.2
        watch.look(np.maximum(reading, 0), ~touched, 1.0)
    positive = (truth > 0.01) & ~touched[:, None]
    assert np.abs(watch.drift_n[positive] - 0.15).max() < 0.05
    assert (watch.drift_n[touched] == 0).all()
    anew = watch.calibrated_anew()
    assert np.linalg.eigvalsh(anew.covariance).min() > -1e-12
    assert (anew.covariance[:20, 3, 3] > made.covariance[:20, 3, 3]).all(), "what cannot be followed gets less sure"


def test_a_table_of_presses_is_read_and_a_wrong_one_named(tmp_path: Path) -> None:
    joints = [f"{name}{unit}" for unit in ("_rad", "_rad_s", "_nm") for name in ROBOT.joint_names]
    head = ",".join([*COLUMNS, *joints])
    rest = "200,0,0,0,0.1,0.1,0.1," + ",".join(["0.5"] * 6 + ["0"] * 6 + ["2"] * 6)
    press = "200,1,1,0,2.1,2.1,2.1," + ",".join(["0.5"] * 6 + ["0.01", "-0.01", "0", "0", "0", "0"] + ["5"] * 6)
    table = tmp_path / "presses.csv"
    table.write_text("\n".join([head, rest, press, press]) + "\n")
    (found,) = read_presses(table, ROBOT, LAYOUT)
    assert isinstance(found, Presses)
    assert found.torque_nm is not None
    assert found.direction is not None
    assert (found.torque_nm == 3).all()
    assert found.direction[0].tolist() == [1, -1, 0, 0, 0, 0]
    for text, says in (
        (head, "no rows"),
        (head.replace("x_mm,", "") + "\n", "no column x_mm"),
        ("\n".join([head, press]), "rows at rest"),
        ("\n".join([head, rest.replace("200", "999"), press]), "cell 999: there are cells 0 to 259"),
        ("\n".join([head, rest.replace("0.1", "nan"), press]), "not finite"),
        ("\n".join([head, rest.replace("0.1", "much"), press]), "much"),
    ):
        table.write_text(text)
        with pytest.raises(CalibrationError, match=says):
            read_presses(table, ROBOT, LAYOUT)


def test_links_that_stand_close_at_home_are_no_reason_to_leave_a_posture_out(
    seed: int, monkeypatch: pytest.MonkeyPatch
) -> None:
    """The thighs of Talos."""
    made: list[FreeSpace] = []

    class Told(FreeSpace):
        def __init__(self, *words: object, **named: object) -> None:
            super().__init__(*words, **named)  # type: ignore[arg-type]
            made.append(self)

    monkeypatch.setattr(post, "FreeSpace", Told)
    talos = robots.load("talos")
    postures_at_post(talos, finished("talos"), draws=1, seed=seed)
    made[0].floor_m = None  # it is the floor of a mounted arm: the legs hang below it
    assert made[0].why_not(gains_of(talos).home) is None
