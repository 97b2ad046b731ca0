# SPDX-License-Identifier: Apache-2.0
"""The benchmark of teaching: delays, what was not taught and thresholds as laws; parts that are none are refused."""

import math

import numpy as np
import pytest

from robotskin.apps.sort.scene import Fruit
from robotskin.apps.sort.script import Sorted, usual_plan
from robotskin.apps.teach.demonstration import Recording
from robotskin.errors import UnknownNameError
from robotskin.teaching.execution import Done
from robotskin.teaching.rules import lessons_of
from robotskin.teaching.signals import Frame
from robotskin_lab.bench.teaching import run
from robotskin_lab.bench.teaching_shown import before_squeezes, delays_s
from robotskin_lab.bench.teaching_sorted import by_threshold, threshold_of
from robotskin_lab.bench.teaching_stacked import TOWER, Tower, tower_of

SEEN = {"idle": "still", "reach": "moves"}


def recording_of(truth: list[str], seen: list[str]) -> Recording:
    frames = [
        Frame(0.02 * n, SEEN.get(word, word), "empty", "still", "no", "nothing", "") for n, word in enumerate(seen)
    ]
    return Recording(frames=frames, truth=truth)


def test_a_delay_is_from_the_true_change_until_it_is_told(seed: int) -> None:
    late = int(np.random.default_rng(seed).integers(0, 15))
    rules = lessons_of((("still" if word == "idle" else "moves", "empty", "still", "no", "nothing"), word) for word in
                       ["idle", "reach"] * 5).rules()  # fmt: skip
    truth = ["idle"] * 20 + ["reach"] * 30 + ["idle"] * 4 + ["reach"] * 20 + ["idle"] * 20
    seen = ["idle"] * (20 + late) + ["reach"] * (74 - 20 - late) + ["reach"] * 20
    found = delays_s(recording_of(truth, seen), rules)
    assert found == [pytest.approx(0.02 * late), 0.0, math.inf]


def test_what_follows_a_squeeze_is_left_out_with_it() -> None:
    truth = ["idle"] * 3 + ["squeeze"] * 4 + ["idle"] * 5 + ["put"] * 2 + ["idle"]
    kept = [label for _, label in before_squeezes(recording_of(truth, ["still"] * len(truth)))]
    assert kept == ["idle"] * 3 + ["put"] * 2 + ["idle"]


def test_a_fruit_that_was_not_measured_is_told_wrong() -> None:
    def one(hard: bool, felt: float | None) -> Sorted:
        fruit = Fruit("orange_1", hard, 6000.0, 0.03, 0.15, (0.0, 0.0), "#ef8e2d")
        return Sorted(fruit, Done(measured={} if felt is None else {"stiffness_n_per_m": felt}), "", 1.0)

    threshold = threshold_of(usual_plan())
    found = [one(True, 2 * threshold), one(False, 0.5 * threshold), one(False, 2 * threshold), one(False, None)]
    assert by_threshold(found, threshold) == 0.5


def test_a_tower_grows_by_a_block_and_blocks_wait_apart(seed: int) -> None:
    tower = tower_of(np.random.default_rng(seed), 4)
    shapes = {one.name: one.shape for one in tower.scene.things}
    grown = Tower(tower.scene, tower.fruits, tower.origin, tower.usual_radius_m, stacked=1)
    higher = grown.places[TOWER] - tower.places[TOWER]
    np.testing.assert_allclose(higher, [0, 0, 2 * tower.usual_radius_m])
    assert shapes["block_1"].length_m == pytest.approx(2 * tower.usual_radius_m)
    shelf = np.array([tower.on_shelf(number) for number in range(4)])
    apart = np.linalg.norm(shelf[:, None] - shelf, axis=2) + np.eye(4)
    assert apart.min() > 2 * tower.usual_radius_m


@pytest.mark.timeout(300)
def test_a_robot_that_is_touched_while_it_is_led_can_be_led_on(seed: int) -> None:
    figures = run(seed=seed, parts="led_soak", soak_seconds=15)
    assert figures["led_soak_touches"] >= 2
    assert figures["led_soak_way_m"] > 0.01
    assert (figures["led_soak_violations"], figures["led_soak_stops"]) == (0, 0)
    assert figures["led_soak_peak_contact_n"] < 25
    assert figures["led_soak_goes_on"] == 1


def test_a_part_that_is_none_is_refused() -> None:
    with pytest.raises(UnknownNameError, match="squash"):
        run(parts="squash")
