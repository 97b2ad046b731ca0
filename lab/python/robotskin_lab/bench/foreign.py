# SPDX-License-Identifier: Apache-2.0
"""`robotskin bench foreign`: another maker's skin pushed through its own frames, and what a large one costs."""

from __future__ import annotations

import socket
import tempfile
import threading
import time
from pathlib import Path
from typing import Annotated, Any

import numpy as np
import typer
from numpy.typing import NDArray

from robotskin.cycle import SafetyState
from robotskin.foreign import Channel, Declared, ForeignSkin, Source
from robotskin.foreign.frames import BinaryFrames, Tally
from robotskin.foreign.scaling import Scaling
from robotskin.layout import Layout, finished
from robotskin.layout.taxel_layout import taxel_layout
from robotskin.robots import load
from robotskin.robots.gains import gains_of
from robotskin.session import PERIOD_S, SkinnedRobot
from robotskin.skin import ForeignInput, SkinState
from robotskin.world import World
from robotskin_lab.bench.foreign_skin import NEWTON, RATE_HZ, ZERO, frame_of, made_taxels
from robotskin_lab.bench.progress import tell
from robotskin_lab.bench.touch_answer import TouchAnswer, answer

PUSHED = 5
SETTLE_S = 3.0
REST_S = 0.6
LARGE = 4000
NOISE = 1.0
"""Counts, standard deviation."""
Counts = NDArray[np.float64]


def run(
    *,
    seed: int = 1,
    taxels: Annotated[
        Path | None, typer.Option(help="A taxel file of the iCub; by default one is made, of 240 taxels.")
    ] = None,
    seconds: Annotated[float, typer.Option(help="Of the load of 4000 taxels.")] = 10.0,
    pushes: Annotated[int, typer.Option(help="Taxels pushed, one after the other.")] = PUSHED,
) -> dict[str, Any]:
    """Push taxels through frames, `SkinInput` and loop; compare with what the gains say. Then 4000 taxels at 100 Hz.

    `foreign_off_…` is the same with the skin switched off: it must be seen to fail.
    """
    random = np.random.default_rng(seed)
    with tempfile.TemporaryDirectory() as folder:
        file = taxels or _made(Path(folder) / "forearm.txt", random, 24)
        figures = _pushes(taxel_layout([file], load("ur5"), link="forearm_link")[0], random, seed, pushes)
        many, _ = taxel_layout([_made(Path(folder) / "many.txt", random, LARGE // 10)], load("ur5"))
    return figures | _load(many, random, seconds)


def _made(file: Path, random: np.random.Generator, triangles: int) -> Path:
    file.write_text(made_taxels(random, triangles))
    return file


def declared(worn: Layout, kind: str = "python", at: str = "made") -> Declared:
    """Forces as u16 counts, 100 frames a second, a slot for each row of the taxel file."""
    slots = int(np.asarray(worn.id).max())
    source = Source(kind, at, slots, number="u16", start=b"\xa5\x5a", sequence="u8", check="crc16")
    return Declared((source,), (Channel("force", NEWTON, ZERO, lowest=0.0, highest=65535.0),), RATE_HZ)


class PushedSkin(SkinnedRobot):
    """A UR5 in MuJoCo whose skin is frames of another maker, in virtual time.

    pushed_n: (slots,) newton on each taxel.
    """

    def __init__(self, worn: Layout, seed: int) -> None:
        robot, whole = load("ur5"), finished("ur5")
        self._declared, self._random = declared(worn), np.random.default_rng(seed)
        source = self._declared.sources[0]
        self._scaling, self.tally = Scaling(source, self._declared, worn), Tally()
        self._frames = BinaryFrames(source, 1, self.tally)
        self.pushed_n = np.zeros(source.slots)
        self._input = ForeignInput(len(worn), self._declared.sensors, self._declared.fresh_s)
        self.world = World(whole, robot, seed, posture=gains_of(robot).home, powered=False)
        self._periods = 0
        super().__init__(robot, worn, self.world.port, self._input)

    def run(self, seconds: float) -> None:
        """Let virtual time pass."""
        for _ in range(round(seconds / PERIOD_S)):
            if self._periods % round(1 / (RATE_HZ * PERIOD_S)) == 0:
                self._send()
            self._periods += 1
            self.world.step(PERIOD_S)
            self.tick(self.world.now_ns)

    def _send(self) -> None:
        noise = self._random.normal(0.0, NOISE, len(self.pushed_n))
        frame = frame_of(self._declared.sources[0], self.pushed_n / NEWTON + ZERO + noise, self._periods)
        counts = self._frames.whole(frame)
        assert counts is not None
        now_ns = self.world.now_ns
        self._input.put(now_ns, now_ns, *self._scaling.samples(counts))

    def begin(self) -> None:
        """Take the forces' zero, then run."""
        self.run(0.1)
        self._input.tare(0.5)
        self.run(REST_S)
        self.start()
        self.run(REST_S)
        assert self.state is SafetyState.running, self.why_not_running()

    def now_s(self) -> float:
        """The world's time."""
        return self.world.now_ns * 1e-9


def _pushes(worn: Layout, random: np.random.Generator, seed: int, pushes: int) -> dict[str, float]:
    session = PushedSkin(worn, seed)
    session.begin()
    answers: list[TouchAnswer] = []
    worst_n = 0.0
    for cell in random.choice(len(worn), pushes, replace=False):
        tell(f"taxel {int(cell)} is pushed")
        slot, force_n = int(worn.id[cell]) - 1, float(random.uniform(6, 12))
        session.pushed_n[slot] = force_n
        answers.append(answer(session, worn, SETTLE_S, session.now_s))
        worst_n = max(worst_n, abs(session.felt_force_n() - force_n))
        session.pushed_n[slot] = 0.0
        session.run(SETTLE_S)
    slots = np.asarray(worn.id)[random.choice(len(worn), PUSHED, replace=False)] - 1
    session.pushed_n[slots] = random.uniform(2, 5, PUSHED)
    together = answer(session, worn, SETTLE_S, session.now_s)
    session.pushed_n[:] = 0.0
    session.run(SETTLE_S)
    session.set_skin(False)
    session.pushed_n[slots[0]] = 10.0
    off = answer(session, worn, 1.0, session.now_s)
    shares = {"displacement": [one.displacement for one in answers], "rise": [one.rise for one in answers]}
    figures = {f"foreign_{name}_ratio_least": min(values) for name, values in shares.items()}
    figures |= {f"foreign_{name}_ratio_most": max(values) for name, values in shares.items()}
    return figures | {
        "foreign_taxels": float(len(worn)),
        "foreign_pushes": float(len(answers)),
        "foreign_asked_rad_least": min(one.asked_rad for one in answers),
        "foreign_together_displacement_ratio": together.displacement,
        "foreign_off_displacement_ratio": off.displacement,
        "foreign_felt_error_n": worst_n,
        "foreign_limit_violations": float(session.controller.report.violations),
        "foreign_bad_frames": float(session.tally.bad),
    }


def _load(worn: Layout, random: np.random.Generator, seconds: float) -> dict[str, float]:
    """Datagrams of a large skin, as declared, from a thread of their own; the loop's reads beside them."""
    tell(f"{len(worn)} taxels at {RATE_HZ:g} Hz")
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as probe:
        probe.bind(("127.0.0.1", 0))
        port = probe.getsockname()[1]
    what = declared(worn, "udp", f"127.0.0.1:{port}")
    source = what.sources[0]
    frames = [frame_of(source, random.integers(0, 4000, source.slots).astype(float), i) for i in range(256)]
    ending = threading.Event()

    def send() -> None:
        with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as sender:
            due, number = time.monotonic(), 0
            while not ending.is_set():
                sender.sendto(frames[number % 256], ("127.0.0.1", port))
                number += 1
                due += 1 / RATE_HZ
                time.sleep(max(0.0, due - time.monotonic()))

    sending = threading.Thread(target=send)
    with ForeignSkin(worn, what) as skin:
        sending.start()
        try:
            alive = skin.await_skin(20.0)
            state = SkinState(len(worn), skin.input.sensors)
            before, began, read_s, reads = skin.statistics(), time.monotonic(), 0.0, 0
            while time.monotonic() < began + seconds:
                start_s = time.thread_time()
                skin.input.read(time.monotonic_ns(), state)
                read_s += time.thread_time() - start_s
                reads += 1
                time.sleep(PERIOD_S)
            after, gone = skin.statistics(), time.monotonic() - began
        finally:
            ending.set()
            sending.join()
    count = after["accepted"] - before["accepted"]
    source_s = (after["thread_cpu_ns"] - before["thread_cpu_ns"]) * 1e-9
    return {
        "foreign_large_taxels": float(alive),
        "foreign_large_rate_hz": count / gone,
        "foreign_large_lost": float(after["frames_missing"] - before["frames_missing"]),
        # Per frame and per read, so that a machine which is late with either does not look quick.
        "foreign_source_cpu_percent": 100 * source_s / max(count, 1) * RATE_HZ,
        "foreign_read_cpu_percent": 100 * read_s / reads / PERIOD_S,
        "foreign_cpu_percent": 100 * (source_s / max(count, 1) * RATE_HZ + read_s / reads / PERIOD_S),
    }
