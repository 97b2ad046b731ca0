# SPDX-License-Identifier: Apache-2.0
"""The largest push that a robot stands, and at how many of them it was stopped."""

import pytest

from robotskin_lab.bench.balance_search import GROWTH, Found, Outcome, largest_stood


def robot(falls_at: float, stops_at: float):
    return lambda size: Outcome(stands=size < falls_at, stopped=size >= stops_at)


@pytest.mark.parametrize("first", [20.0, 50.0, 130.0])
def test_the_limit_is_found_from_below_and_above(first: float) -> None:
    found = largest_stood(robot(100.0, 1000.0), first, 200.0, halvings=2)
    assert 100.0 / GROWTH**0.25 <= found.largest < 100.0
    assert found.running == found.largest
    assert found.stops == 0


def test_pushes_that_it_stood_stopped_are_counted_and_the_running_limit_is_less() -> None:
    found = largest_stood(robot(100.0, 60.0), 50.0, 200.0, halvings=0)
    assert found.largest == pytest.approx(50.0 * GROWTH**4)
    assert found.running == pytest.approx(50.0 * GROWTH)
    assert found.stops == 3


def test_a_robot_that_stands_nothing_has_no_limit_and_a_large_push_is_not_passed() -> None:
    assert largest_stood(robot(0.1, 1000.0), 50.0, 200.0, halvings=2) == Found(0.0, 0.0, 0)
    assert largest_stood(robot(1e9, 1e9), 50.0, 60.0, halvings=0).largest < 60.0 * GROWTH
