# SPDX-License-Identifier: Apache-2.0
"""What a broken link loses is fetched; a dead peer is told; payloads that are none change nothing."""

import contextlib
import random
import time
from collections.abc import Iterator
from contextlib import ExitStack, closing, suppress

import pytest

pytest.importorskip("zenoh")

from fleet_of_two import FleetOfTwo, until

from robotskin.errors import InputError
from robotskin.fleet import FleetError, topics
from robotskin.fleet.link import open_link
from robotskin.fleet.messages import About, Contact, Order, State, number_of, packed, unpacked
from robotskin.fleet.streams import Heard, Stream
from robotskin.fleet.tape import TAPE
from robotskin.fleet.watch import FleetWatch
from robotskin_lab.bench.cut_link import CutLink


@pytest.fixture(scope="module")
def fleet(tmp_path_factory: pytest.TempPathFactory) -> Iterator[FleetOfTwo]:
    made = FleetOfTwo(tmp_path_factory.mktemp("keys"))
    yield made
    made.close()


@pytest.mark.real_time
@pytest.mark.parametrize("way", ["cut", "swallow"])
def test_nothing_is_lost_over_a_broken_link(fleet: FleetOfTwo, way: str) -> None:
    with ExitStack() as held:
        cable = held.enter_context(closing(CutLink(fleet.port)))
        robot = held.enter_context(closing(open_link(fleet.member("left", cable.port))))
        desk = held.enter_context(closing(open_link(fleet.member("desk"))))
        key = topics.of_robot("left", topics.EVENTS)
        heard: list[int] = []
        stream = Stream(robot, key, run=7)
        sent = 0

        def send(seconds: float) -> None:
            nonlocal sent
            ends = time.monotonic() + seconds
            while time.monotonic() < ends:
                stream.put(str(sent).encode())
                sent += 1
                time.sleep(0.02)

        send(0.2)  # before any listens: a late joiner gets it
        listener = Heard(desk, key, lambda run, payload: heard.append(int(payload)))
        until(lambda: len(heard) >= sent)  # what is sent meanwhile may overtake what was kept
        token = robot.liveliness().declare_token(topics.of_robot("left", topics.ALIVE))
        with FleetWatch(fleet.member("screen")) as watch:
            until(lambda: watch.robots().get("left") and watch.robots()["left"].alive)
            send(0.2)
            getattr(cable, way)()
            send(1.5)
            until(lambda: not watch.robots()["left"].alive)
            cable.mend()
            until(lambda: watch.robots()["left"].alive)
        send(0.2)
        with suppress(AssertionError):  # what is missing says more
            until(lambda: len(heard) >= sent)
        assert heard == list(range(sent))
        assert listener.missed == listener.refused == 0
        token.undeclare()


def test_what_the_robot_does_not_keep_any_more_is_counted(fleet: FleetOfTwo) -> None:
    robot, desk = open_link(fleet.member("left")), open_link(fleet.member("desk"))
    key = topics.of_robot("left", topics.TAPE)
    heard: list[bytes] = []
    missed: list[int] = []
    stream = Stream(robot, key, run=8)
    stream.put(b"first")
    listener = Heard(desk, key, lambda run, payload: heard.append(payload), missed.append)
    until(lambda: heard == [b"first"])
    for _ in range(3):
        stream.skip()
    stream.put(b"last")
    robot.put(key, b"without a number")
    until(lambda: listener.refused == 1)
    assert (heard, missed, listener.missed) == ([b"first", b"last"], [3], 3)
    for link in (robot, desk):
        link.close()


STATE = State(
    run=1, stamp_ns=2, robot="ur5", behaviour="skin_compliance", state="running", cells=260, health={"alive": 260},
    contacts=(Contact("tool0", 3, (0, 0, 0.1), (0, 0, 1), (0, 0, -5), (0, 0, 0)),), orders={"desk": 5},
)  # fmt: skip


def test_messages_come_back_and_hostile_bytes_are_refused(request: pytest.FixtureRequest) -> None:
    rng = random.Random(request.config.getoption("--seed"))
    about = About(run=1, facts={"robot": "ur5"}, attachments={"layout.json": "{}"})
    for kind, message in ((State, STATE), (Order, Order(4, "desk")), (About, about)):
        raw = packed(message)
        assert unpacked(kind, raw, 10_000) == message
        refused = 0
        for _ in range(3000):
            bad = bytearray(raw)
            for _ in range(rng.randrange(1, 6)):
                bad[rng.randrange(len(bad))] = rng.randrange(256)
            bad = bad[: rng.randrange(len(bad) + 1)] + rng.randbytes(rng.randrange(4))
            try:
                unpacked(kind, bytes(bad), 10_000)
            except FleetError:
                refused += 1
        assert refused > 1000
        with pytest.raises(FleetError, match="at most 5"):
            unpacked(kind, raw, 5)
    for bad in (b"\x93" * 3000, b"\xdd\xff\xff\xff\xff", b"\xc6\xff\xff\xff\xff"):
        with pytest.raises(FleetError):
            unpacked(State, bad, 10_000)
    for attachment in (None, b"", bytes(15), bytes(17)):
        with pytest.raises(FleetError):
            number_of(attachment)
    for _ in range(2000):
        with contextlib.suppress(InputError):  # and nothing else
            TAPE.unpack(rng.randbytes(rng.randrange(40)))


def test_numbers_that_are_none_are_refused() -> None:
    import msgspec

    odd = Contact("tool0", 3, (float("nan"), 0, 0.1), (0, 0, 1), (0, 0, -5), (0, 0, 0))
    with pytest.raises(FleetError, match="tool0 is no finite number"):
        unpacked(State, packed(msgspec.structs.replace(STATE, contacts=(odd,))), 10_000)
    for change in ({"cells": -1}, {"robot": "x" * 100}, {"health": {str(i): 1 for i in range(30)}}):
        with pytest.raises(FleetError):
            unpacked(State, packed(msgspec.structs.replace(STATE, **change)), 10_000)
