# SPDX-License-Identifier: Apache-2.0
"""A skinned robot in its fleet: what a monitor sees is what it feels, and it obeys stop through its guard."""

import itertools
import threading
import time
from collections.abc import Iterator
from typing import Any

import numpy as np
import pytest

pytest.importorskip("zenoh")

from fleet_of_two import FleetOfTwo, until

from robotskin import layout, robots
from robotskin.cycle import SafetyState
from robotskin.errors import UnknownNameError
from robotskin.fleet import FleetError
from robotskin.fleet.followed import FollowedRobot
from robotskin.fleet.published import Told, published
from robotskin.fleet.table import rows
from robotskin.fleet.watch import FleetWatch
from robotskin.record import Frame
from robotskin.session import Session
from robotskin.sharing.shared import shared

ROBOT = "allegro_right_hand"
CELL, FORCE_N = 20, 5.0
COLUMNS = ("normal_force", "proximity", "acceleration", "temperature", "health", "stamp_ns")


class Kept:
    """A show that keeps every moment."""

    period_s = 1e-4

    def __init__(self) -> None:
        self.moments: dict[int, tuple[np.ndarray, ...]] = {}

    def show(self, frame: Frame, stamp_ns: int) -> None:
        self.moments[frame.time_ns] = taken(frame.skin)

    def tell_network(self, *_: Any) -> None: ...

    def close(self) -> None: ...


def taken(skin: Any) -> tuple[np.ndarray, ...]:
    return tuple(np.array(getattr(skin, name)) for name in COLUMNS)


def felt(watch: FleetWatch, link: str) -> float:
    """Newton on a link, as the monitor knows."""
    state = watch.robots()["left"].state
    found = [one for one in state.contacts if one.link == link] if state is not None else []
    return float(np.linalg.norm(found[0].force)) if found else 0.0


class Running:
    """The robot left, which steps in a thread of its own, and what it truly felt."""

    def __init__(self, fleet: FleetOfTwo, seed: int) -> None:
        self.session = session = Session(robots.load(ROBOT), layout.finished(ROBOT), seed=seed)
        session.boot()
        session.world.push(CELL, FORCE_N)
        self.truth: dict[int, tuple[np.ndarray, ...]] = {}
        self.tellings: list[str] = []
        self._closing = threading.Event()
        self._thread = threading.Thread(target=self._run, args=(fleet,), daemon=True)
        self._thread.start()

    def _run(self, fleet: FleetOfTwo) -> None:
        session = self.session

        def look() -> Told:
            return Told(session.behaviour, session.state.name, session.locked)

        robot = published(fleet.member("left"), session, look, session.lock, self.tellings.append)
        with shared(session, [robot], also=[robot]):
            while not self._closing.wait(0.004):
                session.step()
                self.truth[session.world.now_ns] = taken(session.skin)

    def close(self) -> None:
        self._closing.set()
        self._thread.join()
        self.session.shut_down()


@pytest.fixture(scope="module")
def fleet(tmp_path_factory: pytest.TempPathFactory) -> Iterator[FleetOfTwo]:
    made = FleetOfTwo(tmp_path_factory.mktemp("keys"))
    yield made
    made.close()


@pytest.fixture(scope="module")
def running(fleet: FleetOfTwo, request: pytest.FixtureRequest) -> Iterator[Running]:
    made = Running(fleet, request.config.getoption("--seed"))
    yield made
    made.close()


@pytest.fixture(scope="module")
def watch(fleet: FleetOfTwo, running: Running) -> Iterator[FleetWatch]:
    with FleetWatch(fleet.member("desk")) as made:
        assert made.await_robots(["left"], 180.0) == set()
        yield made


def test_a_monitor_sees_state_skin_and_contacts(running: Running, watch: FleetWatch) -> None:
    skin = running.session.layout
    link = skin.links[int(skin.link[CELL])]
    until(lambda: 0.7 * FORCE_N < felt(watch, link) < 1.3 * FORCE_N)
    seen = watch.robots()["left"]
    assert seen.alive
    assert seen.state is not None
    assert seen.state.robot == ROBOT
    assert seen.state.state == "running"
    assert seen.state.health == {"alive": len(skin)}
    assert [contact.link for contact in seen.state.contacts] == [link]
    (row,) = rows(watch.robots(), time.monotonic())
    assert row.fresh
    assert row.link == "live"
    assert link in row.touched
    (later,) = rows(watch.robots(), time.monotonic() + 5)
    assert not later.fresh
    assert later.touched == "not known", "what is stale never looks fresh"
    (alone,) = rows(watch.robots(), time.monotonic(), connected=False)
    assert alone.link == "not known: no router"


def test_a_follower_gets_the_layout_once_and_every_state_to_the_byte(fleet: FleetOfTwo, running: Running) -> None:
    kept = Kept()
    with FollowedRobot(fleet.member("screen"), "left") as followed:
        assert len(followed.layout) == len(running.session.layout)
        assert np.array_equal(followed.layout.link_from_cell, running.session.layout.link_from_cell)
        assert followed.robot.name == ROBOT
        followed.begin([kept])
        until(lambda: len(kept.moments) > 300)
        assert followed.failure is None
        assert followed.missed == followed.refused == 0
    times = sorted(kept.moments)
    assert len({b - a for a, b in itertools.pairwise(times)}) == 1, "no moment is missing"
    compared = [time_ns for time_ns in times if time_ns in running.truth]
    assert len(compared) > 100
    for time_ns in compared:
        for name, felt, true in zip(COLUMNS, kept.moments[time_ns], running.truth[time_ns], strict=True):
            assert np.array_equal(felt, true), name


def test_what_is_not_there_is_refused(fleet: FleetOfTwo, running: Running, watch: FleetWatch) -> None:
    with pytest.raises(FleetError, match="left"):
        FollowedRobot(fleet.member("screen"), "lift", 0.6)
    with pytest.raises(UnknownNameError, match="left"):
        watch.stop(["lift"])
    with FleetWatch(fleet.member("screen")) as screen, pytest.raises(FleetError, match="only a monitor"):
        screen.stop()


def test_stop_is_obeyed_and_only_one_beside_the_robot_starts_it_again(running: Running, watch: FleetWatch) -> None:
    session = running.session
    assert session.state is SafetyState.running
    took = watch.stop(["left"], 180.0)
    assert took["left"] is not None
    until(lambda: session.state not in (SafetyState.running, SafetyState.degraded))
    session.start()  # as a program would: it stays locked
    until(lambda: (state := watch.robots()["left"].state) is not None and state.state == "ready")
    time.sleep(0.2)
    assert session.state is not SafetyState.running
    state = watch.robots()["left"].state
    assert state is not None
    assert "stopped by desk of the fleet" in state.reason
    session.unlock()
    until(lambda: session.state is SafetyState.running, session.start)


def test_one_that_leaves_is_told(fleet: FleetOfTwo, running: Running, watch: FleetWatch) -> None:
    running.close()
    until(lambda: not watch.robots()["left"].alive)
    (row,) = rows(watch.robots(), time.monotonic())
    assert row.link.startswith("left ")
    assert not row.fresh
