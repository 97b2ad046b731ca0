# SPDX-License-Identifier: Apache-2.0
"""What a short scripted run may conclude from the touches that it drew."""

import numpy as np

from robotskin.scripts.behaviour_script import interventions_at_least


def test_a_few_touches_that_differ_decide_little(seed: int) -> None:
    draw = np.random.default_rng(seed)
    by_touch = draw.poisson(15, 8).tolist()
    by_touch[0] = 90
    assert interventions_at_least(sum(by_touch), by_touch) < 0.5 * sum(by_touch)
    assert interventions_at_least(by_touch[0], by_touch[:1]) == 0


def test_many_touches_that_are_alike_decide_all(seed: int) -> None:
    by_touch = np.random.default_rng(seed).poisson(15, 400).tolist()
    assert interventions_at_least(sum(by_touch), by_touch) > 0.95 * sum(by_touch)


def test_what_comes_without_a_touch_counts_whole(seed: int) -> None:
    alone = int(np.random.default_rng(seed).integers(1, 100))
    assert interventions_at_least(alone, []) == alone
    assert interventions_at_least(alone + 10, [10]) == alone
