# SPDX-License-Identifier: Apache-2.0
"""Writers that are killed at random instants, files that are cut at random bytes: what is lost, what can be read."""

from __future__ import annotations

import contextlib
import mmap
import os
import random
import shutil
import signal
import time
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from mcap.reader import make_reader
from mcap.records import Chunk
from mcap.stream_reader import StreamReader

from robotskin.errors import RobotskinError
from robotskin.record import Recorder, Recording, repair
from robotskin.skin import SkinState
from robotskin_lab.bench.record_load import Rig

ROBOT = "allegro_right_hand"
LEAST_S, MOST_S = 0.1, 0.6


@dataclass
class Lost:
    """Of all runs so far."""

    runs: int = 0
    lost_ms_max: float = 0.0
    unreadable: int = 0
    disagreeing: int = 0

    def add(self, other: Lost) -> None:
        """Both together."""
        self.runs += other.runs
        self.lost_ms_max = max(self.lost_ms_max, other.lost_ms_max)
        self.unreadable += other.unreadable
        self.disagreeing += other.disagreeing

    def take(self, path: Path, newest_ns: int) -> None:
        """Mend a file that should reach `newest_ns`, read it with our reader and a stock one."""
        self.runs += 1
        try:
            found = repair(path)
            Recording(path).samples()
            with path.open("rb") as file:
                stock = sum(1 for _ in make_reader(file).iter_messages())
        except RobotskinError:
            self.unreadable += 1
            return
        self.disagreeing += stock != found.written
        self.lost_ms_max = max(self.lost_ms_max, (newest_ns - found.newest_ns) / 1e6)

    def figures(self) -> dict[str, Any]:
        """By the names of the bench."""
        return {
            "kill_runs": self.runs,
            "lost_ms_max": self.lost_ms_max,
            "unreadable_after_repair": self.unreadable,
            "stock_reader_disagrees": self.disagreeing,
        }


def killed_writers(folder: Path, count: int, seed: int) -> Lost:
    """Processes that record a small skin in real time; the robot's, the writer's or both are ended by SIGKILL."""
    draw, lost = random.Random(seed), Lost()
    for number in range(count):
        path = folder / f"killed{number}.mcap"
        told = mmap.mmap(-1, 16)
        robot = os.fork()
        if robot == 0:
            _write(path, told, seed + number)
        while not _newest_ns(told):
            time.sleep(0.001)
        writer = int.from_bytes(told[8:], "little")
        time.sleep(draw.uniform(LEAST_S, MOST_S))
        killed = draw.choice(((robot,), (writer,), (writer, robot)))
        for process in killed:
            os.kill(process, signal.SIGKILL)
        newest_ns = _newest_ns(told)
        if robot not in killed:
            os.kill(robot, signal.SIGKILL)
        os.waitpid(robot, 0)
        _await_end(writer)
        lost.take(path, newest_ns)
        path.unlink(missing_ok=True)
    return lost


def _newest_ns(told: mmap.mmap) -> int:
    """Host time of the last tick; 0 before the first."""
    return int.from_bytes(told[:8], "little")


def _await_end(process: int) -> None:
    """Of a process that is no child of this one."""
    with contextlib.suppress(FileNotFoundError, ProcessLookupError):
        while Path(f"/proc/{process}/stat").read_text().rsplit(")", 1)[1].split()[0] != "Z":
            time.sleep(0.001)


def _write(path: Path, told: mmap.mmap, seed: int) -> None:
    """In the robot's process; it never returns."""
    rig = Rig.of(ROBOT, seed)
    state = SkinState(len(rig.layout))
    recorder = Recorder(path, rig)
    assert recorder.writer is not None
    told[8:] = recorder.writer.identity.to_bytes(8, "little")
    began, ticks = time.monotonic(), 0
    while True:
        rig.tick(state)
        told[:8] = rig.now_ns.to_bytes(8, "little")
        ticks += 1
        time.sleep(max(0.0, ticks * 1e-3 - (time.monotonic() - began)))


def cut_files(folder: Path, whole: Path, count: int, seed: int) -> Lost:
    """One recording, cut at random bytes behind its first second."""
    draw, lost = random.Random(seed + 1), Lost()
    chunks = _chunks(whole)
    size = whole.stat().st_size
    for _ in range(count):
        at = draw.randrange(chunks[0][0], size)
        path = folder / "cut.mcap"
        shutil.copyfile(whole, path)
        os.truncate(path, at)
        # Of the chunk in which the cut lies nothing can be known but that it was being written.
        newest = max((end_ns for begins, end_ns in chunks if begins <= at), default=0)
        lost.take(path, newest)
    return lost


def _chunks(path: Path) -> list[tuple[int, int]]:
    """(byte at which its record ends, newest time) of each chunk."""
    out = []
    with path.open("rb") as file:
        for record in StreamReader(file, emit_chunks=True).records:
            if isinstance(record, Chunk):
                out.append((file.tell(), record.message_end_time))
    return out
