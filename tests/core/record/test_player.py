# SPDX-License-Identifier: Apache-2.0
"""What was taken down in the middle of a run comes back to the byte, and bytes of a file move nothing they may not."""

import contextlib
import random
import struct

import numpy as np
import pytest

from robotskin import layout, robots
from robotskin.errors import InputError
from robotskin.record.tape import Entry, Player, Recorder, TapeReader
from robotskin.record.tape_memory import TapeMemory
from robotskin.session import Session
from robotskin.skin import SkinState

COLUMNS = (
    "normal_force", "proximity", "distance", "acceleration", "temperature", "stamp_ns", "health", "saturated",
)  # fmt: skip
HEADER = struct.Struct("<IHHq")


def bytes_of(state: SkinState) -> bytes:
    return b"".join(np.asarray(getattr(state, name)).tobytes() for name in COLUMNS) + state.time_ns.to_bytes(8)


class Run:
    """A session recorded from its middle on, under touches, a tare and a change of mode."""

    def __init__(self, seed: int, *, steps: int = 300, driver_mib: float = 64.0, drain_every: int = 20) -> None:
        self.session = Session(robots.load("allegro_right_hand"), layout.finished("allegro_right_hand"), seed=seed)
        self.session.boot()
        memory = [TapeMemory.made("tape", mib).bytes for mib in (driver_mib, 16.0)]
        self.recorder = Recorder(*memory)
        self.recorder.begin_reading(1)
        self.reader = TapeReader(*memory, 1, self.session.layout.skin_model())
        self.recorder.attach(self.session.driver, self.session.reader)
        self.states: dict[int, bytes] = {}
        self.blocks: list[tuple[bytes, bytes]] = []
        draw = random.Random(seed)
        for step in range(steps):
            if step % 60 == 10:
                self.session.world.push(cell=draw.randrange(62), force_n=draw.uniform(1, 20))
            if step == 70:
                self.session.reader.tare(0.05)
            if step == 150:
                self.session.set_mode("event")
            self.session.step()
            self.states[self.session.world.now_ns] = bytes_of(self.session.skin)
            if step % 100 == 50:
                self.recorder.ask_for_keyframe()
            if step % drain_every == 0:
                self.drain()
        self.drain()

    def drain(self) -> None:
        self.blocks.append((self.reader.drain_driver()[0], self.reader.drain_control()))

    def player(self) -> tuple[Player, SkinState]:
        return Player(self.session.layout.skin_model()), SkinState(len(self.session.layout))


def replay(run: Run, first_block: int = 0) -> tuple[int, int]:
    """(reads that came back, reads that differ)."""
    player, state = run.player()
    read = wrong = 0
    for driver, control in run.blocks[first_block:]:
        player.give_driver(driver)
        player.give_control(control)
        while (time_ns := player.advance(state)) is not None:
            read += 1
            wrong += run.states[time_ns] != bytes_of(state)
    return read, wrong


def test_every_state_comes_back_to_the_byte(seed: int) -> None:
    run = Run(seed)
    assert replay(run) == (300, 0)


def test_replay_goes_on_at_a_keyframe(seed: int) -> None:
    run = Run(seed)
    read, wrong = replay(run, first_block=9)
    assert 40 <= read < 200
    assert wrong == 0


def test_what_was_dropped_is_counted_and_never_looks_like_data(seed: int) -> None:
    run = Run(seed, driver_mib=0.03, drain_every=40)
    assert run.recorder.dropped > 0
    read, wrong = replay(run)
    assert wrong == 0
    assert read < 300


def test_a_player_refuses_what_no_recorder_writes() -> None:
    run = Run(1, steps=30)
    player, _ = run.player()
    with pytest.raises(InputError, match="ends within an entry"):
        player.give_driver(b"\x00" * 7)
    with pytest.raises(InputError, match="passes its block"):
        player.give_driver(HEADER.pack(1 << 31, Entry.datagram.value, 0, 0))
    with pytest.raises(InputError, match="impossible time"):
        player.give_control(HEADER.pack(0, Entry.read.value, 0, 2**62))


@pytest.mark.parametrize("round_", range(40))
def test_damaged_blocks_are_refused_or_played_but_never_crash(seed: int, round_: int, damaged_run: Run) -> None:
    draw = random.Random(seed * 1000 + round_)
    player, state = damaged_run.player()

    def damaged(block: bytes) -> bytes:
        out = bytearray(block)
        for _ in range(draw.randrange(4) if out else 0):
            out[draw.randrange(len(out))] = draw.randrange(256)
        return bytes(out[: draw.randrange(len(out) + 1)]) if draw.random() < 0.05 else bytes(out)

    with contextlib.suppress(InputError):
        for driver, control in damaged_run.blocks:
            player.give_driver(damaged(driver))
            player.give_control(damaged(control))
            while player.advance(state) is not None:
                pass
    assert len(state) == 62


@pytest.fixture(scope="module")
def damaged_run() -> Run:
    return Run(3, steps=120)
