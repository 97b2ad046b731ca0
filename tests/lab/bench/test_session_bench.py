# SPDX-License-Identifier: Apache-2.0
"""Threads that run groups of section units side by side change nothing but the time that a session takes."""

import pytest

from robotskin.errors import UnknownNameError
from robotskin.world.ideal import is_ideal
from robotskin_lab.bench import session
from robotskin_lab.bench.session import SLICE_S, run


def test_one_two_and_four_threads_make_the_same_run_to_the_byte(seed: int) -> None:
    figures = run(seed=seed, robot="dual_arm", seconds=0.1, parts="threads")
    assert figures["lanes"] == 2
    assert figures["equal_hashes"] == 1


def test_the_speed_is_named_after_the_cells_that_ran(seed: int) -> None:
    figures = run(seed=seed, robot="ur5", seconds=SLICE_S, threads=1, parts="imperfect")
    assert figures["session_realtime_260"] > 0
    assert figures["over_before"] == pytest.approx(figures["session_realtime_260"] / figures["before_realtime"])


def test_only_a_name_that_ends_in_ideal_is_of_the_ideal_world(seed: int, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(session, "speed_figures", lambda *_: {"session_realtime_1260": is_ideal()})
    figures = run(seed=seed, parts="ideal,imperfect")
    assert figures["session_realtime_1260_ideal"] is True
    assert figures["session_realtime_1260"] is False


def test_a_part_that_does_not_exist_is_refused_with_those_that_do() -> None:
    with pytest.raises(UnknownNameError, match="imperfect"):
        run(parts="perfect")
