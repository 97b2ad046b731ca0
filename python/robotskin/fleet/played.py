# SPDX-License-Identifier: Apache-2.0
"""A recording as a robot of a fleet: it says what it once felt, in real time; stop holds it."""

from __future__ import annotations

import threading
import time
from collections.abc import Callable, Iterable, Iterator, Mapping

import numpy as np

from robotskin.fleet.member import Member
from robotskin.fleet.published import PublishedRobot, Told
from robotskin.record import Recording
from robotskin.record.messages import BLOCK, SKIN_SAMPLES
from robotskin.record.recorder import Following
from robotskin.sharing.follower import Follower

PLAYED = "recording"
"""What such a robot says of its state."""


def blocks(recording: Recording) -> Iterator[tuple[int, bytes, bytes, Mapping[str, bytes]]]:
    """(host time in ns, driver, control, samples) as the recorder wrote them. Raises RecordingFileError."""
    for time_ns, topic, data in recording.written():
        if topic == "/skin/tape":
            yield time_ns, bytes(BLOCK.unpack(data)["entries"]), b"", {}
        elif topic == "/control/tape":
            yield time_ns, b"", bytes(BLOCK.unpack(data)["entries"]), {}
        elif topic == "/skin/samples":
            columns = SKIN_SAMPLES.unpack(data)
            yield time_ns, b"", b"", {name: np.asarray(values).tobytes() for name, values in columns.items()}


def texts_of(recording: Recording) -> dict[str, str]:
    """Its attachments, as a member of a fleet tells them."""
    return {name: data.decode(errors="replace") for name, data in recording.attachments.items()}


def play_once(
    pieces: Iterable[tuple[int, bytes, bytes, Mapping[str, bytes]]],
    to: Following,
    follower: Follower,
    ending: threading.Event,
) -> None:
    """Hand `blocks` on in real time, until their end or until `ending` is set."""
    began: tuple[float, int] | None = None
    for time_ns, driver, control, samples in pieces:
        began = began or (time.monotonic(), time_ns)
        ahead_s = (time_ns - began[1]) * 1e-9 - (time.monotonic() - began[0])
        if ending.wait(max(ahead_s, 0.0)):
            return
        to.take(driver, control, samples)
        if driver or control:
            follower.take(driver, control, samples)


def play(recording: Recording, member: Member, tell: Callable[[str], None] = lambda text: None) -> None:
    """Publish a recording once, in real time, until its end or until a monitor stops it.

    Raises FleetError and RecordingFileError.
    """
    stopped = threading.Event()
    why: list[str] = []

    def obey(reason: str) -> None:
        why.append(reason)
        stopped.set()

    def look() -> Told:
        return Told(recording.path.name, "stopped" if why else PLAYED, "".join(why[:1]))

    robot = PublishedRobot(member, recording.layout, recording.about, texts_of(recording), look, obey, tell)
    follower = Follower(recording.layout, [robot])
    try:
        play_once(blocks(recording), robot, follower, stopped)
        for reason in why:
            tell(reason)
    finally:
        follower.close()
        robot.close()
    if follower.failure is not None:
        raise follower.failure
