# SPDX-License-Identifier: Apache-2.0
"""Threads that run groups of section units side by side change nothing but the time that a session takes."""

import pytest

from robotskin.errors import UnknownNameError
from robotskin_lab.bench.session import run


def test_one_two_and_four_threads_make_the_same_run_to_the_byte(seed: int) -> None:
    figures = run(seed=seed, robot="dual_arm", seconds=0.1, parts="threads")
    assert figures["lanes"] == 2
    assert figures["equal_hashes"] == 1


def test_a_part_that_does_not_exist_is_refused_with_those_that_do() -> None:
    with pytest.raises(UnknownNameError, match="imperfect"):
        run(parts="perfect")
