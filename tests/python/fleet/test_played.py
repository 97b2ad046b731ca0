# SPDX-License-Identifier: Apache-2.0
"""A recording speaks in a fleet in real time, and stop holds it; pages show what is heard, and how fresh that is."""

import threading
import time
from collections.abc import Iterator
from pathlib import Path

import pytest

pytest.importorskip("zenoh")

from fleet_of_two import FleetOfTwo, until

from robotskin import layout, robots
from robotskin.fleet.followed import FollowedRobot
from robotskin.fleet.played import play
from robotskin.fleet.table import Row, rows
from robotskin.fleet.watch import FleetWatch
from robotskin.live.followed_skin import FollowedSkin
from robotskin.record import Recorder, Recording
from robotskin.session import Session
from robotskin.skin import Health
from robotskin.viewer.fleet_page import rows_html

ROBOT = "allegro_right_hand"


@pytest.fixture(scope="module")
def recording(tmp_path_factory: pytest.TempPathFactory, request: pytest.FixtureRequest) -> Recording:
    session = Session(robots.load(ROBOT), layout.finished(ROBOT), seed=request.config.getoption("--seed"), mode="event")
    session.boot()
    path = tmp_path_factory.mktemp("felt") / "felt.mcap"
    with Recorder(path, session):
        session.world.push(20, 5.0)
        session.run(8.0)  # until it is stopped, also where a follower is slow to come
    session.shut_down()
    return Recording(path)


@pytest.fixture
def fleet(tmp_path: Path) -> Iterator[FleetOfTwo]:
    made = FleetOfTwo(tmp_path / "keys")
    yield made
    made.close()


def test_a_recording_is_seen_followed_and_stopped(fleet: FleetOfTwo, recording: Recording) -> None:
    told: list[str] = []
    player = threading.Thread(target=play, args=(recording, fleet.member("left"), told.append))
    player.start()
    with FleetWatch(fleet.member("desk")) as watch:
        assert watch.await_robots(["left"], 180.0) == set()
        with FollowedRobot(fleet.member("screen"), "left") as followed:
            skin = FollowedSkin(followed)
            until(lambda: skin.reading() is not None)
            assert skin.told().startswith(("live from left", "nothing heard"))
            assert (reading := skin.reading()) is not None
            assert len(reading.health) == len(recording.layout)
            assert skin.posture.shape == (followed.robot.joint_count,)
            took = watch.stop(["left"], 180.0)
            assert took["left"] is not None
            player.join()
            assert any("stopped by desk" in one for one in told)
            until(lambda: skin.told().startswith("nothing heard"))
            assert (stale := skin.reading()) is not None
            assert not (stale.health == int(Health.alive)).any(), "what is stale never looks fresh"
            assert (stale.age_s >= reading.age_s - 1e-9).all()
            until(lambda: not watch.robots()["left"].alive)
        (row,) = rows(watch.robots(), time.monotonic())
        assert row.state.startswith("last: felt.mcap: ended")
        assert 'data-fresh="False"' in rows_html([row])


def test_words_of_robots_are_no_html() -> None:
    row = Row("arm", "live", "<script>alert(1)</script>", "100%", "", "none", fresh=True)
    text = rows_html([row])
    assert "<script>" not in text
    assert "&lt;script&gt;" in text
    assert "no robot is in the fleet" in rows_html([])
