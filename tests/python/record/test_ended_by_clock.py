# SPDX-License-Identifier: Apache-2.0
"""A tick that a clock ended is one in the recording, and is not compared with a controller that has no clock."""

import time
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray
from typer.testing import CliRunner

from robotskin import layout, robots
from robotskin.cli.main import app
from robotskin.control import Controller, Fusion, behaviour
from robotskin.live.replay import Replay
from robotskin.record import Recorder, Recording
from robotskin.record.open_loop import open_loop
from robotskin.session import Session

STEPS = 300
AT_ONCE_S = 1e-9


def ended_after(seconds: float) -> Callable[..., Controller]:
    """Controllers whose ticks a clock ends, as on a real port."""

    def made(*arguments: Any, **options: Any) -> Controller:
        return Controller(*arguments, **(options | {"fusion_ends_s": seconds}))

    return made


class Recorded:
    """A session of quadratic programmes, whose ticks a clock ends at once."""

    def __init__(self, path: Path) -> None:
        self.path = path
        session = Session(
            robots.load("allegro_right_hand"), layout.finished("allegro_right_hand"), fusion=Fusion.quadratic
        )
        session.boot()
        counts = session.controller.cycle.fusion_counts
        self.ended: list[bool] = []
        """Of each tick."""
        with Recorder(path, session):
            for step in range(STEPS):
                if step == 20:
                    session.world.push(cell=40, force_n=4.0)
                before = counts.clock_ticks
                session.step()
                self.ended.append(counts.clock_ticks != before)
        session.shut_down()


@pytest.fixture(scope="module")
def recorded(tmp_path_factory: pytest.TempPathFactory) -> Recorded:
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr("robotskin.session.skinned_robot.Controller", ended_after(AT_ONCE_S))
        return Recorded(tmp_path_factory.mktemp("clock") / "clock.mcap")


def test_the_ticks_that_a_clock_ended_are_told_apart_and_not_compared(recorded: Recorded) -> None:
    found = open_loop(Recording(recorded.path), behaviour("skin_compliance").with_fusion(Fusion.quadratic))
    # The first tick has no command before it, and what was sent in the last one is never told.
    ended = recorded.ended[1:-1]
    assert found.ended_by_clock.tolist() == ended
    assert 0 < sum(ended) < len(ended)
    kept = [at for at, by_clock in enumerate(ended) if not by_clock]
    away = found.commanded[kept] - found.recorded[kept]
    assert np.array_equal(found.difference, np.sqrt((away**2).mean(axis=0)))


def test_the_messages_of_commands_tell_it(recorded: Recorded) -> None:
    messages = [fields for _, fields in Recording(recorded.path).messages("/robot/commands")]
    told = np.concatenate([fields["ended_by_clock"] for fields in messages])
    assert len(told) == sum(len(fields["time_ns"]) for fields in messages)
    assert told.sum() == sum(recorded.ended)


def test_the_command_tells_how_many_there_are(recorded: Recorded) -> None:
    told = CliRunner().invoke(app, ["replay", str(recorded.path), "--behaviour", "skin_compliance"]).output
    ended = sum(recorded.ended[1:-1])
    assert f"{ended} of {STEPS - 2} ticks of the recording were ended by the clock; their commands cannot" in told
    assert f"root mean square of {STEPS - 2 - ended} ticks" in " ".join(told.split())


def times_of(recording: Recording) -> NDArray[np.float64]:
    """(STEPS) s of each read since the beginning."""
    return np.array([frame.time_ns - recording.start_ns for frame in recording.frames()]) / 1e9


def test_a_comparison_of_none_but_such_ticks_prints_no_table(recorded: Recorded) -> None:
    recording = Recording(recorded.path)
    first = recorded.ended.index(True)
    assert all(recorded.ended[first : first + 5])
    begin_s, end_s = times_of(recording)[[first, first + 4]] + 1e-4
    found = open_loop(recording, "skin_compliance", begin_s, end_s)
    assert found.ended_by_clock.tolist() == [True] * 3
    assert np.isnan(found.difference).all()
    options = ["--behaviour", "skin_compliance", "--from", str(begin_s), "--to", str(end_s)]
    told = CliRunner().invoke(app, ["replay", str(recorded.path), *options]).output
    assert "3 of 3 ticks" in told
    assert "differs by" not in told


@pytest.mark.parametrize("ended", [False, True])
def test_a_page_compares_none_of_them(recorded: Recorded, ended: bool) -> None:
    recording = Recording(recorded.path)
    tick = recorded.ended.index(True) + (2 if ended else -2)
    at_s = times_of(recording)[tick : tick + 2] - 1e-5
    with Replay(recording, "skin_compliance") as replay:
        replay.seek(at_s[0] + 2e-5)
        replay.step()  # to the read that tells what was sent in that tick
        assert soon(lambda: replay.moment().time_s > at_s[1])
        assert (replay.moment().compared is None) == ended


def soon(done: Callable[[], bool], within_s: float = 20.0) -> bool:
    """Whether it is done in time."""
    ends = time.monotonic() + within_s
    while not done() and time.monotonic() < ends:
        time.sleep(0.005)
    return done()
