# SPDX-License-Identifier: Apache-2.0
"""Robots of a fleet for the bench: live ones and recorded ones, each behind a link that can be broken."""

from __future__ import annotations

import itertools
import sys
import threading
import time
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from multiprocessing.connection import Connection
from pathlib import Path
from typing import Any

import msgspec
import numpy as np

from robotskin import layout, robots
from robotskin.cycle import SafetyState
from robotskin.errors import RobotskinError
from robotskin.fleet import Member, topics
from robotskin.fleet.link import open_link
from robotskin.fleet.played import blocks, play_once, texts_of
from robotskin.fleet.published import PublishedRobot, Told
from robotskin.fleet.router_address import router_address
from robotskin.fleet.streams import Heard
from robotskin.fleet.tape import events_in
from robotskin.record import Recorder, Recording
from robotskin.record.facts import about_of, attachments_of
from robotskin.record.messages import SKIN_SAMPLES
from robotskin.session import Session
from robotskin.sharing.follower import Follower
from robotskin.sharing.shared import shared
from robotskin_lab.bench.cut_link import CutLink

ROBOT = "allegro_right_hand"
TOUCH_S = 0.5
FORCE_N = (2.0, 8.0)
FORGED = "forged"
PERIOD_S = 0.001
SWITCH_S = 0.0005
"""Robots have processes of their own; here several share one, and must not wait for each other."""


@dataclass
class Tally:
    """How many events, and the sum of their times, which tells one that is lost from one that comes twice."""

    events: int = 0
    sum_ns: int = 0

    def add(self, message: bytes) -> None:
        """A message of the stream of events."""
        if message:
            stamps = np.asarray(SKIN_SAMPLES.unpack(message)["stamp_ns"], np.uint64)
            self.events += len(stamps)
            self.sum_ns = (self.sum_ns + int(stamps.sum(dtype=np.uint64))) % 2**64


@dataclass
class Robot:
    """One member with its relay; `guard_ms`: from each order until the guard had left its running states."""

    name: str
    cable: CutLink
    published: PublishedRobot
    sent: Tally = field(default_factory=Tally)
    orders: list[str] = field(default_factory=list)
    guard_ms: list[float] = field(default_factory=list)

    def take(self, driver: bytes, control: bytes, samples: Mapping[str, bytes]) -> None:
        """Count, and hand on."""
        self.sent.add(events_in(samples))
        self.published.take(driver, control, samples)

    # Of a follower of the recorder, and of a show.

    @property
    def period_s(self) -> float:
        """As published."""
        return self.published.period_s

    def begin(self, ask: Callable[[], None]) -> None:
        """Hand on."""
        self.published.begin(ask)

    def show(self, frame: Any, stamp_ns: int) -> None:
        """Hand on."""
        self.published.show(frame, stamp_ns)

    def tell_network(self, *_: object) -> None:
        """Not told."""

    def close(self) -> None:
        """The robot stays in the fleet: a recording is played again and again."""


def joined(
    folder: Path, name: str, skin: Any, facts: Any, attachments: Any, look: Callable[[], Told], obey: Any
) -> Robot:
    """A member behind a relay of its own."""
    member = Member.load(folder / f"{name}.fleet")
    cable = CutLink(router_address(member.router)[1])
    member = msgspec.structs.replace(member, router=f"127.0.0.1:{cable.port}")
    return Robot(name, cable, PublishedRobot(member, skin, facts, attachments, look, obey))


def record(path: Path, seed: int, seconds: float) -> None:
    """What recorded robots felt: touches of drawn cells in the imperfect world, cells in event mode."""
    session = Session(robots.load(ROBOT), layout.finished(ROBOT), seed=seed, mode="event")
    session.boot()
    with Recorder(path, session):
        for touch in touches(session, seed):
            touch()
            session.run(TOUCH_S)
            if session.world.time_s > seconds:
                break
    session.shut_down()


def touches(session: Session, seed: int) -> Any:
    """Push a drawn cell, take the hand away, and again."""
    rng = np.random.default_rng(seed)
    for push in itertools.cycle((True, False)):
        cell, force_n = int(rng.integers(len(session.layout))), float(rng.uniform(*FORCE_N))
        yield (lambda cell=cell, force_n=force_n: session.world.push(cell, force_n)) if push else session.world.release


def serve_recorded(pipe: Connection, folder: Path, names: Sequence[str], path: Path) -> None:
    """Robots that play one recording again and again, until the pipe says `end`."""
    sys.setswitchinterval(SWITCH_S)
    recording = Recording(path)
    attachments = texts_of(recording)
    pieces = list(blocks(recording))
    going, ending = threading.Event(), threading.Event()
    made = []
    for name in names:
        orders: list[str] = []
        made.append(joined(folder, name, recording.layout, recording.about, attachments, _said, orders.append))
        made[-1].orders = orders
        threading.Thread(target=_play, args=(made[-1], recording, pieces, going, ending), daemon=True).start()
    _obey(pipe, made, going, ending)


def _said() -> Told:
    return Told("recorded", "running")


def _play(
    robot: Robot, recording: Recording, pieces: Sequence[Any], going: threading.Event, ending: threading.Event
) -> None:
    going.wait()
    while not ending.is_set():
        follower = Follower(recording.layout, [robot])
        play_once(pieces, robot, follower, ending)
        follower.close()


def serve_live(pipe: Connection, folder: Path, names: Sequence[str], seed: int) -> None:
    """One robot that lives, from the imperfect world to the guard, in real time; stop goes to its guard."""
    (name,) = names
    session = Session(robots.load(ROBOT), layout.finished(ROBOT), seed=seed, mode="event")
    session.boot()
    orders: list[str] = []
    ordered_ns = [0]

    def obey(why: str) -> None:
        session.lock(why)
        ordered_ns[0] = time.monotonic_ns()
        orders.append(why)

    def look() -> Told:
        return Told(session.behaviour, session.state.name, session.locked)

    robot = joined(folder, name, session.layout, about_of(session), attachments_of(session), look, obey)
    robot.orders = orders
    going, ending = threading.Event(), threading.Event()

    def run() -> None:
        going.wait()
        with shared(session, [robot], also=[robot]):
            todo, due_s, steps = touches(session, seed), time.monotonic(), 0
            while not ending.is_set():
                if steps % round(TOUCH_S / PERIOD_S) == 0:
                    next(todo)()
                session.step()
                steps += 1
                if session.locked and session.state not in (SafetyState.running, SafetyState.degraded):
                    if ordered_ns[0]:
                        robot.guard_ms.append((time.monotonic_ns() - ordered_ns[0]) * 1e-6)
                        ordered_ns[0] = 0
                    session.unlock()
                if session.state is SafetyState.ready:
                    session.start()
                due_s = max(due_s + PERIOD_S, time.monotonic())
                time.sleep(max(due_s - time.monotonic(), 0.0))
        session.shut_down()

    thread = threading.Thread(target=run)
    thread.start()
    _obey(pipe, [robot], going, ending)
    thread.join()


def serve_ears(pipe: Connection, folder: Path, names: Sequence[str]) -> None:
    """Hears the events of all robots; told how many there were and how long to wait, it says what it heard."""
    sys.setswitchinterval(SWITCH_S)
    tallies, forged = {name: Tally() for name in names}, [0]

    def heard(name: str) -> Callable[[int, bytes], None]:
        def take(_: int, payload: bytes) -> None:
            try:
                tallies[name].add(payload)
            except RobotskinError:
                forged[0] += 1

        return take

    with open_link(Member.load(folder / "desk.fleet")) as link:
        ears = [Heard(link, topics.of_robot(name, topics.EVENTS), heard(name)) for name in names]
        pipe.send("ready")
        sent, patience_s = pipe.recv()
        ends = time.monotonic() + patience_s
        while any(tallies[name].events < sent[name] for name in names) and time.monotonic() < ends:
            time.sleep(0.1)
        counted = {name: (one.events, one.sum_ns) for name, one in tallies.items()}
        pipe.send((counted, sum(one.missed for one in ears), forged[0] + sum(one.refused for one in ears)))


def _obey(pipe: Connection, made: Sequence[Robot], going: threading.Event, ending: threading.Event) -> None:
    """Begin, break and mend links as the bench says, and tell at the end what was sent."""
    by_name = {robot.name: robot for robot in made}
    pipe.send("ready")
    while True:
        what, *names = pipe.recv()
        if what == "end":
            break
        if what == "go":
            going.set()
        for name in names:
            getattr(by_name[name].cable, what)()
        pipe.send(time.monotonic())
    ending.set()
    time.sleep(0.5)
    pipe.send({
        robot.name: (robot.sent.events, robot.sent.sum_ns, robot.published.dropped,
                     sum(FORGED in order for order in robot.orders), robot.guard_ms)
        for robot in made
    })  # fmt: skip
    pipe.recv()  # the bench has heard the last event
    for robot in made:
        robot.published.close()
        robot.cable.close()
