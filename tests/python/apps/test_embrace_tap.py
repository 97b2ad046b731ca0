# SPDX-License-Identifier: Apache-2.0
"""A tap begins on a free chest, lasts, and asks once it is over."""

import numpy as np
import pytest

from robotskin.apps.embrace.tap import FREE_S, LEAST_S, TAP_N, Tap

LOOK_S = 0.004
FORCE_N = 3 * TAP_N


def asks(told: list[tuple[float, float]]) -> int:
    """How often a chest asks that feels these newton for so many seconds each."""
    tap = Tap(LOOK_S)
    return sum(tap.ends(force_n) for force_n, seconds in told for _ in range(round(seconds / LOOK_S)))


def test_a_tap_asks_once(seed: int) -> None:
    generator = np.random.default_rng(seed)
    for _ in range(20):
        free_s, touched_s = FREE_S + generator.uniform(0.1, 3), LEAST_S + generator.uniform(0.1, 2)
        assert asks([(0.0, free_s), (FORCE_N, touched_s), (0.0, 5.0)]) == 1


def test_a_touch_that_lasts_does_not_ask_before_it_is_over() -> None:
    assert asks([(0.0, 2.0), (FORCE_N, 20.0)]) == 0


def test_what_was_held_and_is_let_go_is_no_tap() -> None:
    assert asks([(FORCE_N, 1.0), (0.0, 5.0)]) == 0


def test_what_slides_down_along_the_chest_is_no_tap() -> None:
    assert asks([(0.0, 2.0), *[(FORCE_N, 0.5 * LEAST_S), (0.0, 0.5 * FREE_S)] * 5]) == 0


@pytest.mark.parametrize("force_n", [0.5 * TAP_N, TAP_N])
def test_a_faint_touch_is_no_tap(force_n: float) -> None:
    assert asks([(0.0, 2.0), (force_n, 1.0), (0.0, 1.0)]) == 0
