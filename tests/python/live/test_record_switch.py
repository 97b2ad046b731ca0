# SPDX-License-Identifier: Apache-2.0
"""The page's switch records a running session into files that play back, and never holds the session up."""

import time
from collections.abc import Callable
from pathlib import Path

import pytest

from robotskin import layout, robots
from robotskin.live.live_session import LiveSession
from robotskin.record import Recorder, RecordError, Recording
from robotskin.record.recorder import is_recorded
from robotskin.session import Session
from robotskin.viewer.session_view import Recordable

ROBOT = "allegro_right_hand"


def wait_for(what: Callable[[], bool]) -> None:
    until = time.monotonic() + 60.0
    while not what():
        assert time.monotonic() < until
        time.sleep(0.02)


def test_the_switch_records_one_file_after_the_other(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, request: pytest.FixtureRequest
) -> None:
    monkeypatch.chdir(tmp_path)
    session = Session(robots.load(ROBOT), layout.finished(ROBOT), seed=request.config.getoption("--seed"))
    session.boot()
    with LiveSession(session) as live:
        assert isinstance(live, Recordable)
        assert live.recording == ""
        live.record(False)
        live.record(True)
        live.record(True)
        assert "recording into" in live.recording
        began_s = live.snapshot().time_s
        wait_for(lambda: is_recorded(session))
        live.set_skin(False)
        wait_for(lambda: live.snapshot().time_s > began_s + 0.3)
        live.record(False)
        assert not is_recorded(session)
        (first,) = tmp_path.glob("*.mcap")
        first = first.rename(tmp_path / "first.mcap")
        live.record(True)
        began_s = live.snapshot().time_s
        wait_for(lambda: live.snapshot().time_s > began_s + 0.3)
    second = next(path for path in tmp_path.glob("*.mcap") if path != first)
    assert not is_recorded(session)
    asked = [bytes(message["text"]).decode() for _, message in Recording(first).messages("/operator")]
    assert asked == ["skin off"]
    for path in (first, second):
        assert sum(1 for _ in Recording(path).frames()) > 200


def test_a_skin_that_is_recorded_already_is_not_recorded_twice(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, request: pytest.FixtureRequest
) -> None:
    monkeypatch.chdir(tmp_path)
    session = Session(robots.load(ROBOT), layout.finished(ROBOT), seed=request.config.getoption("--seed"))
    session.boot()
    with Recorder(tmp_path / "whole.mcap", session), LiveSession(session) as live:
        with pytest.raises(RecordError, match="already"):
            live.record(True)
        began_s = live.snapshot().time_s
        wait_for(lambda: live.snapshot().time_s > began_s + 0.2)
    assert [path.name for path in tmp_path.glob("*.mcap")] == ["whole.mcap"]
    assert sum(1 for _ in Recording(tmp_path / "whole.mcap").frames()) > 100
