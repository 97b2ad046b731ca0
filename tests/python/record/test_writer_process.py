# SPDX-License-Identifier: Apache-2.0
"""A file is written beside the robot: whatever ends, the rest goes on, and what was written is readable."""

import gc
import mmap
import os
import resource
import signal
import time
from collections.abc import Callable
from pathlib import Path

import pytest
from mcap.records import Attachment, Message

from robotskin import layout, robots
from robotskin.record import Recorder, RecordError, Recording, repair
from robotskin.record.mcap_file import is_whole, records
from robotskin.session import Session

FULL_BYTES = 2_000_000
PATIENCE_S = 180.0


def test_a_full_disk_is_told_at_once_and_the_robot_goes_on(tmp_path: Path, seed: int) -> None:
    path, told = tmp_path / "full.mcap", list[str]()
    session = booted(seed)
    recorder = Recorder(path, session, tell=told.append)
    assert recorder.writer is not None
    full = path.stat().st_size + FULL_BYTES
    resource.prlimit(recorder.writer.identity, resource.RLIMIT_FSIZE, (full, full))
    wait_for(session, lambda: told)
    assert str(path) in told[0]
    assert "readable" in told[0]
    before = session.world.now_ns
    session.step()
    assert session.world.now_ns > before
    with pytest.raises(RecordError, match="readable"):
        recorder.close()
    assert len(told) == 1
    assert repair(path).messages > 0
    assert len(Recording(path).samples()["key"]) > 0


def test_a_robot_that_is_killed_leaves_a_whole_file(tmp_path: Path, seed: int) -> None:
    """The process that writes it lives on, and writes what is still on the tapes."""
    path, newest = tmp_path / "killed.mcap", mmap.mmap(-1, 8)
    robot = os.fork()
    if robot == 0:
        session = booted(seed)
        Recorder(path, session)
        while True:
            session.step()
            newest[:] = session.world.now_ns.to_bytes(8, "little")
    ends = time.monotonic() + PATIENCE_S
    while not any(newest[:]):
        assert time.monotonic() < ends
        time.sleep(0.01)
    time.sleep(0.2)
    os.kill(robot, signal.SIGKILL)
    os.waitpid(robot, 0)
    while not is_whole(path):
        assert time.monotonic() < ends
        time.sleep(0.01)
    last = max(int(frame.time_ns) for frame in Recording(path).frames())
    assert last >= int.from_bytes(newest[:], "little")


def test_a_writer_that_is_killed_is_told_and_the_robot_goes_on(tmp_path: Path, seed: int) -> None:
    path, told = tmp_path / "writer.mcap", list[str]()
    session, looking_on = booted(seed), Counting()
    recorder = Recorder(path, session, followers=[looking_on], tell=told.append)
    assert recorder.writer is not None
    for _ in range(100):
        session.step()
    recorder.drain()
    os.kill(recorder.writer.identity, signal.SIGKILL)
    wait_for(session, lambda: told)
    assert "signal 9" in told[0]
    before = looking_on.taken
    wait_for(session, lambda: looking_on.taken > before)
    with pytest.raises(RecordError, match="signal 9"):
        recorder.close()
    assert repair(path).messages > 0
    assert len(list(Recording(path).frames())) >= 99


def test_a_file_that_exists_stays_as_it_is(tmp_path: Path, seed: int) -> None:
    path = tmp_path / "taken.mcap"
    path.write_text("mine")
    with pytest.raises(RecordError, match="choose another name"):
        Recorder(path, booted(seed))
    assert path.read_text() == "mine"
    with pytest.raises(RecordError, match="is no folder"):
        Recorder(path / "in_a_file.mcap", booted(seed))


def test_what_the_file_holds_is_what_the_operator_did_and_what_came_late(tmp_path: Path, seed: int) -> None:
    path = tmp_path / "told.mcap"
    session = booted(seed)
    with Recorder(path, session) as recorder:
        session.step()
        recorder.note("ein Stoß")
        recorder.attach_late("found.json", "first")
        recorder.attach_late("found.json", "second")
    found = list(records(path))
    assert [one.data for one in found if isinstance(one, Attachment) and one.name == "found.json"] == [b"second"]
    assert any("ein Stoß".encode() in one.data for one in found if isinstance(one, Message))


def test_a_recording_that_has_ended_leaves_nothing_open(tmp_path: Path, seed: int) -> None:
    """Each switch of the page kept 80 MB of tapes as long as the robot ran."""

    def left() -> tuple[int, int]:
        gc.collect()
        maps = Path("/proc/self/maps").read_text()
        return maps.count("memfd:"), len(list(Path("/proc/self/fd").iterdir()))

    session = booted(seed)
    before = left()
    for number in range(3):
        with Recorder(tmp_path / f"{number}.mcap", session, followers=[Counting()]) as recorder:
            session.step()
        assert recorder.dropped == 0
        recorder.note("too late")
    assert left() == before


class Counting:
    """A follower that counts."""

    taken = 0

    def begin(self, ask: Callable[[], None]) -> None: ...

    def take(self, *_: object) -> None:
        self.taken += 1

    def close(self) -> None: ...


class Failing:
    """A follower that takes nothing."""

    def begin(self, ask: Callable[[], None]) -> None: ...

    def take(self, *_: object) -> None:
        raise ValueError("not this")

    def close(self) -> None: ...


def test_a_follower_that_fails_says_nothing_of_a_file(seed: int) -> None:
    """It said so at each turn of the recorder's thread, of a file that there was none of."""
    told = list[str]()
    session = booted(seed)
    recorder = Recorder(None, session, followers=[Failing()], tell=told.append)
    wait_for(session, lambda: recorder.error)
    with pytest.raises(RecordError, match="not this"):
        recorder.close()
    assert not told


def booted(seed: int) -> Session:
    session = Session(robots.load("allegro_right_hand"), layout.finished("allegro_right_hand"), seed=seed)
    session.boot()
    return session


def wait_for(session: Session, holds: Callable[[], object]) -> None:
    """Step on until it holds."""
    ends = time.monotonic() + PATIENCE_S
    while not holds():
        assert time.monotonic() < ends
        session.step()
