# SPDX-License-Identifier: Apache-2.0
"""The page of a recording: played, paused, stepped and sought, it shows what was felt then."""

from collections.abc import Callable, Iterator
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np
import pytest
from browsing import choose, free_port, insist, opened, wait_for

from robotskin import layout, robots
from robotskin.errors import InputError
from robotskin.live.live_session import LiveSession
from robotskin.live.replay import SPEED_MAX, Replay
from robotskin.record import Recorder, Recording
from robotskin.record.open_loop import open_loop
from robotskin.session import Session
from robotskin.viewer.page import Page
from robotskin.viewer.replay_page import ReplayPage, activity_strip, compared_text
from robotskin.viewer.scene import SHADOWS

if TYPE_CHECKING:
    from playwright import sync_api

ROBOT = "allegro_right_hand"
TOUCH_S, SECONDS = 0.4, 1.2


@pytest.fixture(scope="module")
def recording(tmp_path_factory: pytest.TempPathFactory, request: pytest.FixtureRequest) -> Recording:
    path = tmp_path_factory.mktemp("replay") / "hand.mcap"
    session = Session(
        robots.load(ROBOT), layout.finished(ROBOT), seed=request.config.getoption("--seed"), link="in process"
    )
    session.boot()
    with Recorder(path, session):
        session.run(seconds=TOUCH_S)
        session.world.push(cell=40, force_n=6.0)
        session.run(seconds=0.4)
        session.world.release()
        session.run(seconds=SECONDS - TOUCH_S - 0.4)
    return Recording(path)


@pytest.fixture
def replay(recording: Recording) -> Iterator[Replay]:
    with Replay(recording) as replay:
        yield replay


def until(what: Callable[[], bool]) -> None:
    wait_for(what, "the replay does not follow")


def test_a_moment_that_is_sought_is_the_one_of_the_recording(replay: Replay, recording: Recording) -> None:
    truth = {
        round((frame.time_ns - recording.start_ns) * 1e-9, 6): np.array(frame.skin.normal_force)
        for frame in recording.frames()
    }
    assert not replay.moment().playing
    for time_s in (0.9, 0.2, 0.6):
        replay.seek(time_s)
        until(lambda time_s=time_s: abs(replay.moment().time_s - time_s) < 0.005)
        moment = replay.moment()
        assert np.array_equal(moment.skin.normal_force, truth[round(moment.time_s, 6)])
    before = replay.moment().time_s
    replay.step()
    until(lambda: replay.moment().time_s > before)
    assert replay.moment().time_s - before == pytest.approx(0.001, abs=1e-6)


def test_the_end_is_the_last_read_where_a_recording_ends_with_something_else(
    replay: Replay, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(replay, "seconds", replay.seconds + 0.3)
    replay.seek(replay.seconds)
    until(lambda: replay.moment().time_s > SECONDS - 0.2)


def test_it_plays_to_its_end_and_then_from_its_beginning(replay: Replay) -> None:
    replay.set_speed(SPEED_MAX)
    replay.play()
    until(lambda: not replay.moment().playing and replay.moment().time_s > SECONDS - 0.2)
    replay.set_speed(0.01)
    replay.play()
    until(lambda: replay.moment().playing and replay.moment().time_s < 0.5)
    replay.pause()
    until(lambda: not replay.moment().playing)


def test_a_behaviour_is_compared_and_says_since_when(recording: Recording) -> None:
    """After going to another time its goal and fusion were new, and nothing said so."""
    whole = open_loop(recording, "kinesthetic_joint")
    with Replay(recording, "kinesthetic_joint") as replay:
        replay.set_speed(SPEED_MAX)
        replay.play()
        until(lambda: not replay.moment().playing and replay.moment().time_s > SECONDS - 0.2)
        compared = replay.moment().compared
        assert compared is not None
        assert compared.since_s < 0.1
        assert np.array_equal(compared.commanded, whole.commanded[-1])
        assert np.array_equal(compared.sent, whole.recorded[-1])
        replay.seek(0.6)
        until(lambda: abs(replay.moment().time_s - 0.6) < 0.005)
        assert replay.moment().compared is None
        replay.step()
        until(lambda: replay.moment().compared is not None)
        anew = replay.moment().compared
    assert anew is not None
    assert anew.since_s == pytest.approx(0.6, abs=0.005)
    text = compared_text(anew, replay.robot.joint_names)
    assert f'data-since="{anew.since_s:.3f}"' in text
    assert text.count("<tr>") == 1 + replay.robot.joint_count


def test_what_cannot_be_is_refused(replay: Replay) -> None:
    for time_s in (-0.1, SECONDS + 1.0, float("nan")):
        with pytest.raises(InputError, match="the recording has 0 to"):
            replay.seek(time_s)
    for speed in (0.0, SPEED_MAX + 1.0, float("nan")):
        with pytest.raises(InputError, match="speed"):
            replay.set_speed(speed)


def test_the_strip_shows_when_something_was_felt(recording: Recording) -> None:
    activity = recording.activity(100)
    assert activity[45:55].max() > 1.0 > activity[:20].max()
    strip = activity_strip(activity, 0.5, recording.seconds)
    assert 'data-replay="0.500"' in strip
    assert strip.count("<rect") == np.count_nonzero(activity)
    assert "highest 0.0 N" in activity_strip(np.zeros(10), 0.0, 1.0)


def test_a_session_is_recorded_by_a_switch_in_the_page(
    browser: "sync_api.Browser", tmp_path: Path, monkeypatch: pytest.MonkeyPatch, request: pytest.FixtureRequest
) -> None:
    monkeypatch.setenv(SHADOWS, "off")
    monkeypatch.chdir(tmp_path)
    session = Session(robots.load(ROBOT), layout.finished(ROBOT), seed=request.config.getoption("--seed"))
    session.boot()
    with LiveSession(session) as live, Page(live, free_port()) as served:
        page = opened(browser, served.address)
        page.get_by_text("Recording", exact=True).click()
        switch = page.get_by_label("Record", exact=True)
        switch.check()
        page.get_by_text("recording into").wait_for()
        began_s = live.snapshot().time_s
        until(lambda: live.snapshot().time_s > began_s + 0.3)
        switch.uncheck()
        page.get_by_text("recorded into").wait_for()
    (path,) = tmp_path.glob("*.mcap")
    assert Recording(path).seconds > 0.3


def test_a_recording_is_played_and_sought_in_the_page(
    browser: "sync_api.Browser", replay: Replay, recording: Recording, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv(SHADOWS, "off")
    with ReplayPage(replay, "hand", recording.activity(), free_port()) as served:
        page = opened(browser, served.address)
        strip = page.locator("[data-replay]").first

        def shown_s() -> float:
            return float(strip.get_attribute("data-replay") or "nan")

        assert shown_s() == pytest.approx(replay.moment().time_s, abs=0.01)
        choose(page, "Speed", "0.1 ×")
        page.get_by_role("button", name="Play").click()
        until(lambda: shown_s() > 0.02)
        page.get_by_role("button", name="Pause").click()
        until(lambda: not replay.moment().playing)
        time = page.locator("div:has(> div > p > label:text-is('Time [s]')) input[type='text']").last

        def typed() -> None:
            time.fill("0.7")
            time.press("Enter")

        insist(typed, lambda: abs(replay.moment().time_s - 0.7) < 0.01, "the replay does not go there")
        until(lambda: abs(shown_s() - 0.7) < 0.01)
        page.get_by_role("button", name="Step").click()
        until(lambda: replay.moment().time_s > 0.7)
