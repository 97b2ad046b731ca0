# SPDX-License-Identifier: Apache-2.0
"""Another robot's skin, from its fleet: its recorder's tapes, played here as they come."""

from __future__ import annotations

import time
from typing import Self

import zenoh

from robotskin.errors import InputError, UnknownNameError
from robotskin.fleet import topics
from robotskin.fleet.errors import FleetError
from robotskin.fleet.link import MESSAGE_BYTES_MAX, open_link
from robotskin.fleet.member import Member
from robotskin.fleet.messages import About, unpacked
from robotskin.fleet.streams import Heard
from robotskin.fleet.tape import TAPE
from robotskin.layout import Layout
from robotskin.record.mcap_file import DAMAGE
from robotskin.record.recorded_robot import URDF, robot_of
from robotskin.record.recording import layout_of
from robotskin.robots import Robot
from robotskin.sharing.follower import Follower, Show

ASK_S = 0.5


class FollowedRobot:
    """Follows a robot by name until `close`; layout and robot come from it, once.

    Every skin state is equal to the byte to the one on the robot. After a broken link nothing is missing that the
    robot still keeps; beyond that it goes on at the next keyframe, and `missed` tells how many messages are lost.

    Raises FleetError where the router is not reached, the robot is not there, or what it says of itself cannot be.
    """

    def __init__(self, member: Member, name: str, patience_s: float = 5.0) -> None:
        self.name = name
        self.ended = ""
        """Why nothing more will come; empty while it may."""
        self.refused = 0
        """Messages that were none."""
        self._link = open_link(member, patience_s)
        try:
            about = _about(self._link, name, patience_s)
            self.run, self.facts = about.run, about.facts
            self.layout: Layout = _layout(about, name)
            self.robot: Robot = _robot(about, self.layout, name)
        except BaseException:
            self._link.close()
            raise
        self._follower: Follower | None = None
        self._heard: Heard | None = None

    def begin(self, shows: list[Show]) -> None:
        """Show its moments, from the last keyframe on."""
        self._follower = Follower(self.layout, shows)
        self._heard = Heard(self._link, topics.of_robot(self.name, topics.TAPE), self._take, lambda count: self._miss())

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *_: object) -> None:
        self.close()

    def close(self) -> None:
        """Follow no more; closes what was shown."""
        if self._heard is not None:
            self._heard.close()
        if self._follower is not None:
            self._follower.close()
        self._link.close()

    @property
    def missed(self) -> int:
        """Messages that are lost for good."""
        return 0 if self._heard is None else self._heard.missed

    @property
    def failure(self) -> Exception | None:
        """What ended the showing, where something did."""
        return None if self._follower is None else self._follower.failure

    # ---- Threads of Zenoh ----

    def _take(self, run: int, payload: bytes) -> None:
        if run != self.run:
            self.ended = f"{self.name} was started anew, maybe with another skin: follow it anew"
            return
        try:
            blocks = TAPE.unpack(payload)
        except InputError:
            self.refused += 1
            return
        if self._follower is not None:
            self._follower.take(bytes(blocks["driver"]), bytes(blocks["control"]), {})

    def _miss(self) -> None:
        if self._follower is not None:
            self._follower.miss()


def _about(link: zenoh.Session, name: str, patience_s: float) -> About:
    """Asked for until it comes. Raises FleetError."""
    ends = time.monotonic() + patience_s
    while True:
        for reply in link.get(topics.of_robot(name, topics.ABOUT), timeout=ASK_S):
            if reply.ok is not None:
                return unpacked(About, reply.ok.payload.to_bytes(), MESSAGE_BYTES_MAX)
        if time.monotonic() > ends:
            break
        time.sleep(0.05)
    tokens = link.liveliness().get(topics.of_robot("*", topics.ALIVE), timeout=ASK_S)
    live = [topics.robot_of(str(reply.ok.key_expr)) for reply in tokens if reply.ok is not None]
    unknown = UnknownNameError("robot of the fleet", name, live)
    raise FleetError(f"{unknown}" if name not in live else f"fleet: {name} is there, but does not say what it is")


def _layout(about: About, name: str) -> Layout:
    if "layout.json" not in about.attachments:
        raise FleetError(f"fleet: {name} tells no layout")
    try:
        return layout_of({key: text.encode() for key, text in about.attachments.items()})
    except DAMAGE as error:
        raise FleetError(f"fleet: the layout of {name} is damaged: {error}") from error


def _robot(about: About, layout: Layout, name: str) -> Robot:
    found = robot_of(layout.robot, about.attachments.get(URDF, "").encode())
    if found is None:
        raise FleetError(f"fleet: {name} does not say what robot it is")
    return found
