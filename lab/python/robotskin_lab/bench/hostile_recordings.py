# SPDX-License-Identifier: Apache-2.0
"""Recordings as an attacker or a failing disk would make them: each is refused by name or read, in bounded memory."""

from __future__ import annotations

import contextlib
import os
import random
import resource
import shutil
import signal
import tempfile
import time
import traceback
from multiprocessing import Pipe
from multiprocessing.connection import Connection
from pathlib import Path
from typing import Annotated, Any

import typer
from mcap.reader import make_reader
from mcap.records import Attachment

from robotskin import layout, robots
from robotskin.errors import RobotskinError
from robotskin.record import Recorder, Recording, repair
from robotskin.record.recorded_robot import URDF, robot_of
from robotskin.record.summary import summarise
from robotskin.session import Session
from robotskin_lab.bench.hostile_files import Parts, hostile
from robotskin_lab.bench.progress import tell, tell_step

ROBOT = "allegro_right_hand"
MEMORY_MAX = 2 << 30
"""Bytes of address space that a reader may take beyond what it has before the first file."""
HANG_S = 60
FILES_A_PROCESS = 200


def run(
    *,
    seed: int = 1,
    seconds: Annotated[float, typer.Option(help="Of new files.", min=1)] = 600.0,
    keep: Annotated[Path | None, typer.Option(help="Keep files with a finding in this folder.")] = None,
) -> dict[str, Any]:
    """Random bytes in every type of record, sizes that lie, cut and foreign files: opened, played, summed up, mended.

    `findings`: files that led to anything but a reading or a refusal that names the file: another error, a crash,
    a hang, memory beyond 2 GiB, or a mended file that a stock reader reads otherwise.
    """
    counts = {"read": 0, "refused": 0, "mended": 0}
    findings: list[tuple[int, str]] = []
    memory_mb = 0.0
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        parts = Parts.of(touched_hand(folder / "whole.mcap", seed))
        began, number = time.monotonic(), 0
        while time.monotonic() - began < seconds:
            first = number
            ours, theirs = Pipe()
            child = os.fork()
            if child == 0:
                _read_all(theirs, folder, parts, seed, first)
            theirs.close()
            for drawn in range(first, first + FILES_A_PROCESS):
                tell_step(f"hostile recordings: {number} files, {len(findings)} findings")
                said = _answer(ours, child)
                memory_mb = max(memory_mb, said.get("memory_mb", 0.0))
                for what in said.get("done", ()):
                    counts[what] += 1
                number = drawn + 1
                if finding := said.get("finding"):
                    findings.append((drawn, finding))
                    tell(f"file {drawn} of seed {seed}: {finding}")
                    if keep is not None:
                        keep.mkdir(parents=True, exist_ok=True)
                        shutil.copyfile(folder / "hostile.mcap", keep / f"{seed}_{drawn}.mcap")
                        (keep / f"{seed}_{drawn}.txt").write_text(finding)
                if "ended" in said:
                    break
                ours.send("next")
                if time.monotonic() - began > seconds:
                    break
            ours.close()
            with contextlib.suppress(ProcessLookupError):
                os.kill(child, signal.SIGKILL)
            with contextlib.suppress(ChildProcessError):
                os.waitpid(child, 0)
    tell("")
    return {
        "hostile_files": number,
        "hostile_read": counts["read"],
        "hostile_refused": counts["refused"],
        "hostile_mended": counts["mended"],
        "hostile_memory_mb_max": memory_mb,
        "findings": len(findings),
    }


def _answer(pipe: Connection, child: int) -> dict[str, Any]:
    """What the reader says of one file; of one that ended, how."""
    if not pipe.poll(HANG_S):
        return {"finding": f"hangs for more than {HANG_S} s", "ended": True}
    try:
        said: dict[str, Any] = pipe.recv()
    except EOFError:
        _, status = os.waitpid(child, 0)
        return {"finding": f"the reader's process ended with status {status}", "ended": True}
    return said


def touched_hand(path: Path, seed: int, seconds: float = 0.3) -> Path:
    """A hand that is touched, in event mode, with a word of its operator."""
    session = Session(robots.load(ROBOT), layout.finished(ROBOT), seed=seed, mode="event", link="in process")
    session.boot()
    with Recorder(path, session) as recorder:
        recorder.note("push")
        session.world.push(40, 6.0)
        session.run(seconds)
    session.shut_down()
    return path


def _read_all(pipe: Connection, folder: Path, parts: Parts, seed: int, first: int) -> None:
    """In the child: make and read a share of the files; it never returns."""
    resource.setrlimit(resource.RLIMIT_CORE, (0, 0))
    used = int(Path("/proc/self/statm").read_text().split()[0]) * resource.getpagesize()
    resource.setrlimit(resource.RLIMIT_AS, (used + MEMORY_MAX, used + MEMORY_MAX))
    path = folder / "hostile.mcap"
    known = {one.data for one in parts.records if isinstance(one, Attachment)}
    try:
        for number in range(first, first + FILES_A_PROCESS):
            path.write_bytes(hostile(parts, random.Random(f"{seed} {number}")))
            said = _judged(path, known)
            said["memory_mb"] = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1e3
            pipe.send(said)
            pipe.recv()  # the file is kept where it is wanted
    finally:
        os._exit(0)


def _judged(path: Path, known: set[bytes]) -> dict[str, Any]:
    """What a file led to: "done" names what could be done; "finding" is there where something was wrong."""
    done = []
    try:
        done.append("read" if _read(path, known) else "refused")
        if _mended(path):
            done.append("mended")
    except Exception as error:
        where = traceback.extract_tb(error.__traceback__)[-1]
        return {
            "done": done,
            "finding": f"{type(error).__name__}: {error} ({Path(where.filename).name}:{where.lineno})",
        }
    return {"done": done}


def _read(path: Path, known: set[bytes]) -> bool:
    """Whether a file is a recording to its end; it is refused by name otherwise. Any other error is a finding.

    known: attachments that need not be tried again.
    """
    try:
        recording = Recording(path)
        repr(recording)
        recording.activity()
        summarise(recording, 0.0, float("inf"))
        for topic in ("/robot/joints", "/robot/commands", "/operator"):
            for _ in recording.messages(topic):
                pass
        if (urdf := recording.attachments.get(URDF, b"")) not in known:
            with contextlib.suppress(RobotskinError):  # it names its own file
                robot_of("", urdf)
    except RobotskinError as error:
        if isinstance(error.__cause__, MemoryError) or path.name not in str(error):
            raise RuntimeError(f"refused otherwise than by name: {type(error).__name__}: {error}") from error
        return False
    return True


def _mended(path: Path) -> bool:
    """Whether what is left of a file could be mended, and a stock reader reads just that."""
    mended = path.with_name("mended.mcap")
    shutil.copyfile(path, mended)
    try:
        found = repair(mended)
    except RobotskinError:
        return False
    if found.was_whole:
        return False
    with mended.open("rb") as file:
        stock = sum(1 for _ in make_reader(file).iter_messages())
    if stock != found.written:
        raise RuntimeError(f"a mended file of {found.written} messages has {stock} for a stock reader")
    return True
