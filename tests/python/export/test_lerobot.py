# SPDX-License-Identifier: Apache-2.0
"""A LeRobot data set holds every event of the recording, and foreign tools open it."""

import json
import shutil
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest

from robotskin import layout, robots
from robotskin.export import ExportFormatError, export_lerobot
from robotskin.record import Recorder, Recording
from robotskin.session import Session

parquet = pytest.importorskip("pyarrow.parquet")
FPS, WINDOW = 30, 5


@pytest.fixture(scope="module")
def made(tmp_path_factory: pytest.TempPathFactory, request: pytest.FixtureRequest) -> tuple[Recording, Path]:
    folder = tmp_path_factory.mktemp("lerobot")
    hand = robots.load("allegro_right_hand")
    seed = request.config.getoption("--seed")
    session = Session(hand, layout.finished(hand.name), seed=seed, mode="event", link="in process")
    session.boot()
    with Recorder(folder / "hand.mcap", session):
        session.world.push(cell=40, force_n=6.0)
        session.run(seconds=0.8)
        session.world.release()
        session.run(seconds=0.3)
    recording = Recording(folder / "hand.mcap")
    export_lerobot(recording, folder / "set", fps=FPS, window=WINDOW)
    return recording, folder / "set"


def test_every_event_comes_back(made: tuple[Recording, Path]) -> None:
    recording, folder = made
    told = parquet.read_table(folder / "events/chunk-000/file-000.parquet").to_pydict()
    samples = recording.samples()
    events = (samples["flags"] & 1) != 0
    assert events.sum() == len(told["cell"]) > 100
    for name in ("stamp_ns", "normal_force", "proximity", "acceleration", "temperature"):
        assert np.array_equal(np.array(told[name], samples[name].dtype), samples[name][events], equal_nan=True)
    keys = (np.asarray(recording.layout.group, np.int64) << 16) | np.asarray(recording.layout.id, np.int64)
    assert np.array_equal(keys[told["cell"]], samples["key"][events])


def test_a_frame_holds_the_last_value_of_every_cell(made: tuple[Recording, Path]) -> None:
    recording, folder = made
    table = parquet.read_table(folder / "data/chunk-000/file-000.parquet")
    force = np.array(table["observation.tactile.force"].to_pylist())
    window = np.array(table["observation.tactile.window"].to_pylist())
    assert force.shape == (int(recording.seconds * FPS), 62)
    assert window.shape == (len(force), WINDOW, 62)
    assert np.array_equal(window[:, -1], force)
    samples = recording.samples()
    keys = (np.asarray(recording.layout.group, np.int64) << 16) | np.asarray(recording.layout.id, np.int64)
    frame = len(force) * 2 // 3
    until = recording.start_ns + (frame + 1) * 1e9 / FPS
    for cell in (0, 40, 61):
        own = (samples["key"] == keys[cell]) & (samples["stamp_ns"] <= until)
        newest = np.flatnonzero(own)[samples["stamp_ns"][own].argmax()]
        assert force[frame, cell] == pytest.approx(samples["normal_force"][newest].sum(), abs=1e-5)


def test_it_says_what_it_is(made: tuple[Recording, Path]) -> None:
    recording, folder = made
    info = json.loads((folder / "meta/info.json").read_text())
    assert (info["codebase_version"], info["fps"], info["total_episodes"]) == ("v3.0", FPS, 1)
    assert parquet.read_table(folder / info["robotskin"]["cells_path"]).num_rows == len(recording.layout)


@pytest.mark.skipif(shutil.which("lerobot-doctor", path=str(Path(sys.executable).parent)) is None, reason="no doctor")
def test_a_foreign_doctor_finds_nothing_broken(made: tuple[Recording, Path]) -> None:
    doctor = Path(sys.executable).parent / "lerobot-doctor"
    said = subprocess.run([doctor, made[1]], capture_output=True, text=True, check=False).stdout
    assert "PASS" in said
    assert "FAIL" not in said


def test_hugging_face_opens_it(made: tuple[Recording, Path], tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("HF_HUB_OFFLINE", "1")
    datasets = pytest.importorskip("datasets", reason="Hugging Face datasets is not installed")
    recording, folder = made
    file = str(folder / "data/chunk-000/file-000.parquet")
    read = datasets.load_dataset("parquet", data_files=file, split="train", cache_dir=str(tmp_path))
    features = json.loads((folder / "meta/info.json").read_text())["features"]
    assert set(read.features) == set(features)
    assert read.num_rows == int(recording.seconds * FPS)
    assert np.shape(read[0]["observation.tactile.window"]) == (WINDOW, len(recording.layout))


def test_an_existing_folder_is_left_alone(made: tuple[Recording, Path], tmp_path: Path) -> None:
    with pytest.raises(ExportFormatError, match="choose another folder"):
        export_lerobot(made[0], tmp_path)
