# SPDX-License-Identifier: Apache-2.0
"""Drawn touches keep their bounds, go everywhere but to the legs, and a seed repeats them."""

import numpy as np

from robotskin_lab.bench.balance_cells import worn_by_robot
from robotskin_lab.bench.balance_drawn import (
    FORCE_N,
    LARGEST_IMPULSE_NS,
    PAUSE_S,
    SHORT_S,
    TOUCH_S,
    drawn_touch,
    touched_links,
)

DRAWS = 400


def test_touches_keep_their_bounds_and_a_seed_repeats_them(seed: int) -> None:
    layout = worn_by_robot()
    links = touched_links(layout)
    draw, again = np.random.default_rng(seed), np.random.default_rng(seed)
    touches = [drawn_touch(draw, links) for _ in range(DRAWS)]
    assert touches == [drawn_touch(again, links) for _ in range(DRAWS)]
    assert {layout.links[layout.link[touch.cell]] for touch in touches} == set(links)
    short = [touch for touch in touches if touch.seconds < SHORT_S]
    assert short
    assert all(touch.force_n * touch.seconds <= LARGEST_IMPULSE_NS + 1e-9 for touch in short)
    for touch in touches:
        assert FORCE_N[0] <= touch.force_n <= FORCE_N[1]
        assert TOUCH_S[0] <= touch.seconds <= TOUCH_S[1]
        assert PAUSE_S[0] <= touch.pause_s <= PAUSE_S[1]


def test_no_leg_is_touched() -> None:
    assert not [link for link in touched_links(worn_by_robot()) if "leg" in link]
