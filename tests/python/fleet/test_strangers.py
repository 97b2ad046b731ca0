# SPDX-License-Identifier: Apache-2.0
"""Nothing that a stranger sends is accepted: on real sockets, through the shipping router."""

import json
import socket
import time
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import msgspec
import pytest

zenoh = pytest.importorskip("zenoh")

from fleet_of_two import FleetOfTwo, free_port, until  # noqa: E402

from robotskin.fleet import FleetError, Member, Role, topics  # noqa: E402
from robotskin.fleet.authority import Authority  # noqa: E402
from robotskin.fleet.link import open_link, open_router  # noqa: E402
from robotskin.fleet.messages import Order, packed  # noqa: E402

SETTLE_S = 0.3


@pytest.fixture(scope="module")
def fleet(tmp_path_factory: pytest.TempPathFactory) -> Iterator[FleetOfTwo]:
    made = FleetOfTwo(tmp_path_factory.mktemp("keys"))
    yield made
    made.close()


class Ears:
    """All that the robot left and the monitor are told; what is here has passed the router."""

    def __init__(self, fleet: FleetOfTwo) -> None:
        self.heard: list[bytes] = []
        self.left, self.desk = open_link(fleet.member("left")), open_link(fleet.member("desk"))
        for link, key in ((self.left, "robotskin/**"), (self.desk, "robotskin/**")):
            link.declare_subscriber(key, self._hear)
        self.left.declare_subscriber(topics.stop_of("left"), self._hear)
        self.desk.declare_subscriber(topics.of_robot("*", topics.STATE), self._hear)
        self.desk.liveliness().declare_subscriber(topics.of_robot("*", topics.ALIVE), self._hear, history=True)

    def _hear(self, sample: Any) -> None:
        self.heard.append(str(sample.key_expr).encode() + b" " + sample.payload.to_bytes())

    def close(self) -> None:
        self.left.close()
        self.desk.close()


@pytest.fixture(scope="module")
def ears(fleet: FleetOfTwo) -> Iterator[Ears]:
    made = Ears(fleet)
    yield made
    made.close()


def speak(link: Any, fleet_name: str = "left") -> Any:
    """Every kind of message that would be worth forging; the token lives as long as it is kept."""
    for what in (topics.STATE, topics.TAPE, topics.EVENTS, topics.ABOUT):
        link.put(topics.of_robot(fleet_name, what), b"forged")
        link.put(topics.of_robot(fleet_name, what) + "/@adv/pub/1/2", b"forged")
    link.put(topics.stop_of(fleet_name), packed(Order(1, "forged")))
    link.put(topics.stop_of("*"), packed(Order(1, "forged")))
    return link.liveliness().declare_token(topics.of_robot(fleet_name, topics.ALIVE))


def allowed_come_through(fleet: FleetOfTwo, ears: Ears) -> None:
    """So that silence means something."""
    count = len(ears.heard)
    until(
        lambda: any(b"allowed" in one for one in ears.heard[count:]),
        lambda: ears.left.put(topics.of_robot("left", topics.STATE), b"allowed"),
    )
    until(
        lambda: any(one.startswith(b"robotskin/stop/left") for one in ears.heard[count:]),
        lambda: ears.desk.put(topics.stop_of("left"), b"allowed"),
    )
    time.sleep(SETTLE_S)


def test_without_a_certificate_or_with_a_foreign_one_none_gets_in(fleet: FleetOfTwo, ears: Ears) -> None:
    left = fleet.member("left")
    foreign = Authority.fresh()
    false_left = foreign.member("left", Role.robot, left.router)
    believing = msgspec.structs.replace(false_left, authority=left.authority)
    for stranger in (false_left, believing):
        with pytest.raises(FleetError, match="lets robot left in"):
            speak(open_link(stranger, 0.5))
    for tls, protocol in (({"root_ca_certificate_base64": ""}, "tls"), ({}, "tcp")):
        router = {"endpoints": [f"{protocol}/127.0.0.1:{fleet.port}"], "timeout_ms": 500, "exit_on_failure": True}
        config = {
            "mode": "client", "scouting": {"multicast": {"enabled": False}}, "connect": router,
            "transport": {"link": {"tls": tls}},
        }  # fmt: skip
        with pytest.raises(zenoh.ZError):
            speak(zenoh.open(zenoh.Config.from_json5(json.dumps(config))))
    with socket.create_connection(("127.0.0.1", fleet.port)) as raw:
        raw.sendall(bytes(range(256)) * 64)
    allowed_come_through(fleet, ears)
    assert not [one for one in ears.heard if b"forged" in one]


@pytest.mark.parametrize("name", ["right", "screen"])
def test_a_right_certificate_may_do_no_more_than_its_own(fleet: FleetOfTwo, ears: Ears, name: str) -> None:
    with open_link(fleet.member(name)) as link:
        until(lambda: link.info.routers_zid())
        spied: list[bytes] = []
        link.declare_subscriber(topics.stop_of("left"), lambda sample: spied.append(sample.payload.to_bytes()))
        about = topics.of_robot("left", topics.ABOUT)
        link.declare_queryable(about, lambda query: query.reply(about, b"forged"))
        token = speak(link)
        allowed_come_through(fleet, ears)
        replies = [reply.ok for reply in ears.desk.get(about, timeout=0.5)]
        assert not [one for one in replies if one is not None]
        assert not [one for one in ears.heard if b"forged" in one]
        assert not [one for one in ears.heard if topics.ALIVE.encode() in one], "none but left may say that it lives"
        token.undeclare()
        assert b"allowed" not in spied, (
            "what it says itself stays with it; what the monitor says to others is not for it"
        )


def test_a_robot_cannot_pass_for_the_router(fleet: FleetOfTwo) -> None:
    """Its certificate serves under no address, so that the others do not believe it."""
    address = f"127.0.0.1:{free_port()}"
    with open_router(fleet.member("right"), address), pytest.raises(FleetError):
        open_link(msgspec.structs.replace(fleet.member("left"), router=address), 0.5)


def test_one_that_is_struck_off_the_list_is_let_do_nothing(fleet: FleetOfTwo, tmp_path: Path) -> None:
    from fleet_of_two import free_port

    from robotskin.fleet.link import open_router

    address = f"127.0.0.1:{free_port()}"
    own: Member = msgspec.structs.replace(fleet.member("router"), router=address)
    kept = msgspec.structs.replace(own, members=tuple(one for one in own.members if one.name != "left"))
    heard: list[str] = []
    with open_router(kept):
        desk, left, right = (
            open_link(msgspec.structs.replace(fleet.member(name), router=address)) for name in ("desk", "left", "right")
        )
        desk.declare_subscriber(topics.of_robot("*", topics.STATE), lambda sample: heard.append(str(sample.key_expr)))
        left.put(topics.of_robot("left", topics.STATE), b"x")
        until(lambda: heard, lambda: right.put(topics.of_robot("right", topics.STATE), b"x"))
        left.put(topics.of_robot("left", topics.STATE), b"x")
        time.sleep(SETTLE_S)
        assert set(heard) == {topics.of_robot("right", topics.STATE)}
        for link in (desk, left, right):
            link.close()
