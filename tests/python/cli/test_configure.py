# SPDX-License-Identifier: Apache-2.0
"""`robotskin configure` on recorded data: what it finds, and with --check what has changed since."""

import json
from dataclasses import replace

import numpy as np
import pytest
from typer.testing import CliRunner

from robotskin.cli.main import app
from robotskin.layout import Layout, finished
from robotskin.robots import load
from robotskin.robots.free_space import FreeSpace
from robotskin.selfconfig.babbling.plan import plan_babbling
from robotskin.selfconfig.kinematics.start import KinematicsError
from robotskin.selfconfig.reconstruction.accuracy import mean_errors
from robotskin.selfconfig.simulated.limb import AccelerometerImperfections
from robotskin.selfconfig.simulated.motion import AccelerometerFaults
from robotskin.selfconfig.simulated.recording import simulate_babbling

START = np.array([0.0, -1.2, 1.0, -0.8, -1.0, 0.3])
STEPS = "topology,activity,reconstruction,localisation"


@pytest.fixture
def recordings(tmp_path, seed: int):
    """Paths of a recording, of one after a patch slid by 8 mm, and the two layouts."""
    robot, worn = load("ur5"), finished("ur5")
    random = np.random.default_rng(seed)
    plan = plan_babbling(
        FreeSpace(robot, floor_m=0.0), START, random, postures=5, swing_postures=2, cycles=2, candidates=80
    )
    faults = AccelerometerFaults.draw(random, len(worn), AccelerometerImperfections())
    number = next(index for index, patch in enumerate(worn.patches) if patch.link == "wrist_2_link")
    pose = worn.link_from_cell.copy()
    pose[worn.patch == number, :3, 3] += [0.0, 0.0, 0.008]
    slid = replace(worn, link_from_cell=pose)
    paths = tmp_path / "before.npz", tmp_path / "after.npz"
    for layout, path in zip((worn, slid), paths, strict=True):
        simulate_babbling(robot, layout, plan, random, faults=faults).save(path)
    return *paths, worn, slid


@pytest.mark.parametrize(
    ("arguments", "named"),
    [
        (["--steps", "topology,guessing"], "unknown step 'guessing'"),
        (["--steps", "topology,localisation"], "localisation: builds on reconstruction"),
        (["--steps", "topology", "--map", "map.npz"], "--map map.npz"),
        (["--steps", "topology", "-o", "found.json"], "--output found.json"),
        (["--steps", "topology,reconstruction", "--urdf", "found.urdf"], "--urdf found.urdf"),
        (["--report", "nowhere/found.html"], "--report nowhere/found.html"),
        (["--output", "."], "--output ."),
        (["--steps", "topology,reconstruction", "--camera"], "--camera: places patches in the step localisation"),
        (["--check", "half.npz"], "half.npz: no whole numpy archive"),
        (["--map-picture", "map.foo"], "map.foo: the name must end in .png or .svg or .pdf"),
        (["--from", "half.npz"], "half.npz: no whole numpy archive"),
    ],
)
def test_what_cannot_be_done_is_refused_before_the_robot_moves(
    arguments: list[str], named: str, tmp_path, monkeypatch: pytest.MonkeyPatch
) -> None:
    def moved(*_: object, **__: object) -> None:
        raise AssertionError("the robot moved")

    monkeypatch.chdir(tmp_path)
    monkeypatch.setattr("robotskin.configuring.configured.babble", moved)
    (tmp_path / "half.npz").write_bytes(b"PK and then nothing")
    result = CliRunner().invoke(app, ["configure", "ur5", *arguments])
    assert result.exit_code == 2, result.output
    assert named in " ".join(result.stderr.split())
    assert [path.name for path in tmp_path.iterdir()] == ["half.npz"]


@pytest.mark.parametrize("name", ["felt.csv", "felt.CSV"])
def test_a_series_is_told_by_the_ending_of_its_name(name: str, tmp_path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    (tmp_path / name).write_text("time_s,a_x,a_y,a_z\n0,0,0,9.81\n")
    result = CliRunner().invoke(app, ["configure", "ur5", "--from", name])
    assert result.exit_code == 2, result.output
    assert f"{name}: no column shoulder_pan_joint" in " ".join(result.stderr.split())


def test_check_names_the_patch_that_slid_and_places_only_that(recordings, tmp_path) -> None:
    before, after, worn, slid = recordings
    target = tmp_path / "found.json"
    arguments = ["configure", "ur5", "--steps", STEPS, "--output", str(target), "--check", str(before), "--from"]
    same = CliRunner().invoke(app, [*arguments, str(before)])
    assert same.exit_code == 0, same.output
    assert "no changes" in same.output
    assert "configured anew: none" in same.output
    told = " ".join(same.output.split())
    assert "cells stay open (patches 0, 1)" in told, "those of the shoulder, whose axis is vertical"
    assert "tell more: --camera" in told
    report = tmp_path / "found.html"
    found = CliRunner().invoke(app, [*arguments, str(after), "--report", str(report)])
    assert found.exit_code == 0, found.output
    assert "wrist_2_link moved" in found.output
    told = report.read_text(encoding="utf-8")
    assert told.index("On the robot") < told.index("<h2>Patches") < told.index("<h2>Computing"), (
        "the picture comes first"
    )
    assert told.rindex("<h2>") == told.index("<h2>Computing"), "what it cost comes last"
    assert all(f"<td>{step}</td>" in told.split("<h2>Computing")[1] for step in STEPS.split(","))
    assert "<td>1:" in told, "a cell is named by group and id"
    layout = Layout.load(target)
    key = {int(cell): row for row, cell in enumerate(slid.group.astype(np.int64) << 16 | slid.id)}
    rows = np.array([key[int(cell)] for cell in layout.group.astype(np.int64) << 16 | layout.id])
    there = np.array([layout.links[index] == "wrist_2_link" for index in layout.link])
    assert there.sum() > 10
    placed, where = layout.link_from_cell[there], rows[there]
    assert mean_errors(placed, slid.link_from_cell[where])[1] < 3.0
    assert mean_errors(placed, worn.link_from_cell[where])[1] > 5.0


def test_a_robot_reacts_by_the_map_that_it_has_learnt(recordings, tmp_path, seed: int) -> None:
    before, *_ = recordings
    learnt, figures = tmp_path / "map.npz", tmp_path / "run.json"
    steps = ["--steps", f"{STEPS},map", "--output", str(tmp_path / "found.json"), "--map", str(learnt)]
    made = CliRunner().invoke(app, ["configure", "ur5", *steps, "--from", str(before)])
    assert made.exit_code == 0, made.output
    told = ["--skin-map", str(learnt), "--seconds", "1.0", "--seed", str(seed), "--json", str(figures)]
    moved = CliRunner().invoke(app, ["run", "ur5", "--behaviour", "kinesthetic_joint", "--headless", *told])
    found = json.loads(figures.read_text())
    # Reactions of a map are rougher than those of a model: the guard may change more commands than a run calls fine.
    assert moved.exit_code == 0 or found["intervention_share"] > 0.01, moved.output
    assert found["intervention_share"] < 0.05
    assert found["running"] == 1
    assert found["limit_violations"] == 0
    assert found["largest_move_m"] > 0.003


def test_a_urdf_that_cannot_be_written_is_an_error_and_the_layout_is_kept(recordings, tmp_path, monkeypatch) -> None:
    before, *_ = recordings
    layout, urdf = tmp_path / "found.json", tmp_path / "found.urdf"

    def unsettled(*_arguments: object) -> None:
        raise KinematicsError("no settled kinematics")

    monkeypatch.setattr("robotskin.selfconfig.configure.kinematics_from", unsettled)
    arguments = ["configure", "ur5", "--from", str(before), "-o", str(layout), "--urdf", str(urdf)]
    result = CliRunner().invoke(app, [*arguments, "--steps", f"{STEPS},kinematics"])
    assert result.exit_code == 2
    assert "found.urdf: not written, no kinematics: no settled kinematics" in " ".join(result.output.split())
    assert len(Layout.load(layout)) > 0
    assert not urdf.exists()


def test_a_camera_needs_a_skin_to_look_at(tmp_path) -> None:
    recording = tmp_path / "felt.npz"
    recording.write_bytes(b"")
    refused = CliRunner().invoke(app, ["configure", "ur5", "--camera", "--from", str(recording)])
    assert refused.exit_code != 0
    assert "--layout must name it" in f"{refused.exception} {refused.output}"


def test_one_file_of_all_that_a_robot_on_its_feet_felt_is_refused_and_its_mounted_twin_named(tmp_path) -> None:
    answer = CliRunner().invoke(app, ["configure", "talos_standing", "--record", str(tmp_path / "felt.mcap")])
    assert answer.exit_code == 2
    assert "such as that of talos" in " ".join(answer.output.split())
