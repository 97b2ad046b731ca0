# SPDX-License-Identifier: Apache-2.0
"""Recordings of other versions, and what is no recording, open or are refused by name."""

from collections.abc import Callable
from pathlib import Path

import pytest

from robotskin import layout, robots
from robotskin.record import Recorder, Recording, RecordingFileError, facts, repair
from robotskin.record import recorder as recorder_module
from robotskin.record.open_loop import open_loop, recorded_gains
from robotskin.session import Session


@pytest.mark.parametrize("version", [0, 2])
def test_another_format_version_is_refused_by_name(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, version: int
) -> None:
    monkeypatch.setattr(facts, "FORMAT_VERSION", version)
    path = tmp_path / "other.mcap"
    with Recorder(path, Session(robots.load("allegro_right_hand"), layout.finished("allegro_right_hand"))):
        pass
    with pytest.raises(RecordingFileError, match=rf"other\.mcap: format version {version}, written by robotskin 0\."):
        Recording(path)


def test_what_an_earlier_robotskin_did_not_write_may_be_missing(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, seed: int
) -> None:
    told, kept = facts.about_of, facts.attachments_of
    early = ("format_version", "robotskin", "cells", "robot", "started")
    monkeypatch.setattr(recorder_module, "about_of", lambda one: {name: told(one)[name] for name in early})
    monkeypatch.setattr(recorder_module, "attachments_of", lambda one: {"layout.json": kept(one)["layout.json"]})
    session = Session(robots.load("allegro_right_hand"), layout.finished("allegro_right_hand"), seed=seed)
    session.boot()
    path = tmp_path / "early.mcap"
    with Recorder(path, session):
        session.run(0.1)
    recording = Recording(path)
    assert recorded_gains(recording) is None
    assert sum(1 for _ in recording.frames()) == 100
    assert len(open_loop(recording, "skin_compliance").commanded) == 98


@pytest.mark.parametrize("opens", [Recording, repair])
def test_what_is_no_file_is_refused_with_what_to_name(tmp_path: Path, opens: Callable[[Path], object]) -> None:
    with pytest.raises(RecordingFileError, match=r"none\.mcap: no such file; `robotskin record"):
        opens(tmp_path / "none.mcap")
    assert list(tmp_path.iterdir()) == []
    (tmp_path / "touches.mcap").touch()
    with pytest.raises(RecordingFileError, match=r"is a folder; name a recording in it, such as touches\.mcap"):
        opens(tmp_path)
