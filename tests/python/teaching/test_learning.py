# SPDX-License-Identifier: Apache-2.0
"""Plans of demonstrations: they part where the demonstrations do, by the property that was measured before."""

from pathlib import Path

import numpy as np
import pytest

from robotskin.teaching.gripper import TeachingError
from robotskin.teaching.knowledge import load_knowledge
from robotskin.teaching.learning import Act, Demonstration, acts_of, learn_plan
from robotskin.teaching.plan import load_plan
from robotskin.teaching.signals import Frame


def shown(hard: bool, stiffness: float, diameter: float) -> Demonstration:
    to = "container" if hard else "bin"
    acts = (Act("reach", "thing"), Act("take", "thing"), Act("put"), Act("squeeze"), Act("put", to), Act("release"))
    return Demonstration(acts, {"stiffness_n_per_m": stiffness, "diameter_m": diameter})


def test_a_plan_parts_by_what_was_measured_before(seed: int, tmp_path: Path) -> None:
    generator, found = np.random.default_rng(seed), 0
    for _ in range(20):
        stiffness = [(6000.0 if hard else 3000.0) * np.exp(0.1 * generator.normal()) for hard in (True, False) * 2]
        sets = [
            shown(number % 2 == 0, float(value), 0.066 + 0.003 * float(generator.uniform(-1, 1)))
            for number, value in enumerate(stiffness)
        ]
        plan = learn_plan(sets, "orange")
        first = next(step.when for step in plan.steps if step.when is not None)
        if first.property == "stiffness_n_per_m" and first.above is not None:
            found += 1
            assert max(stiffness[1::2]) < first.above < min(stiffness[0::2])
        assert [step.at for step in plan.steps if step.when is not None] == ["container", "bin"]
        assert [step.do for step in plan.steps] == ["reach", "take", "squeeze", "put", "put", "release"]
        plan.save(tmp_path / "one.plan")
        assert load_plan(tmp_path / "one.plan") == plan
        plan.require_doable(load_knowledge(), "panda_gripper", ["thing", "container", "bin"])
    assert found == 20


def test_one_fruit_that_stands_far_out_moves_the_threshold_by_its_share() -> None:
    usual = [(6400.0, True), (2900.0, False), (7700.0, True), (4250.0, False)]
    plan = learn_plan([shown(hard, stiffness, 0.066) for stiffness, hard in usual], "orange")
    threshold = next(step.when.above for step in plan.steps if step.when is not None)
    assert threshold == pytest.approx((6400.0 * 7700.0 * 2900.0 * 4250.0) ** 0.25, rel=1e-3)
    far = [(6000.0, True), (3000.0, False), (30000.0, True), (3000.0, False)]
    plan = learn_plan([shown(hard, stiffness, 0.066) for stiffness, hard in far], "orange")
    threshold = next(step.when.above for step in plan.steps if step.when is not None)
    assert threshold == pytest.approx((6000.0 * 3000.0) ** 0.5, rel=1e-3)  # the middle of all lies above the first


def test_demonstrations_that_nothing_tells_apart_are_refused() -> None:
    parting = [Demonstration((Act("reach", "thing"), Act("put", to)), {}) for to in ("container", "bin")]
    with pytest.raises(TeachingError, match="nothing measured before tells which"):
        learn_plan(parting, "orange")
    others = [Demonstration((Act(do, "thing"),), {}) for do in ("take", "reach")]
    with pytest.raises(TeachingError, match="demonstration 2 does reach"):
        learn_plan(others, "orange")
    with pytest.raises(TeachingError, match="no demonstration"):
        learn_plan([], "orange")


@pytest.mark.parametrize(
    "stiffness",
    [[(6000.0, True), (3000.0, False), (7000.0, False)], [(6000, True), (2800, False)] * 2 + [(7000, False)]],
)
def test_a_condition_tells_what_was_shown_or_the_demonstration_that_differs_is_named(
    stiffness: list[tuple[float, bool]],
) -> None:
    sets = [shown(hard, value, 0.066) for value, hard in stiffness]
    if len(sets) < 5:
        with pytest.raises(TeachingError, match=r"demonstration \d of 3 did otherwise"):
            learn_plan(sets, "orange")
        return
    at_hard, at_soft = (step.at for step in learn_plan(sets, "orange").steps if step.when is not None)
    assert (at_hard, at_soft) == ("container", "bin")  # four of five


def test_an_act_that_ended_at_no_known_place_is_refused() -> None:
    lost = Demonstration((Act("reach", ""), Act("take", "thing")), {})
    with pytest.raises(TeachingError, match="demonstration 1: a reach ended at no known place"):
        learn_plan([lost], "orange")
    dropped = (Act("reach", "thing"), Act("take", "thing"), Act("put"), Act("squeeze"), Act("put"), Act("release"))
    with pytest.raises(TeachingError, match="demonstration 2: the thing was let go at no known place"):
        learn_plan([shown(True, 6000, 0.066), Demonstration(dropped, {"stiffness_n_per_m": 3000.0})], "orange")
    with pytest.raises(TeachingError, match="nothing was done"):
        learn_plan([Demonstration((), {})], "orange")


def frames_of(runs: list[tuple[float, str]]) -> tuple[list[Frame], list[str]]:
    """Frames and labels of runs: seconds, and `activity place`."""
    frames, told, now = [], [], 0.0
    for seconds, words in runs:
        label, _, near = words.partition(" ")
        for _ in range(round(seconds / 0.02)):
            frames.append(Frame(now, "still", "empty", "still", "no", "nothing", near))
            told.append(label)
            now += 0.02
    return frames, told


def test_acts_are_runs_that_last_at_the_place_where_they_end() -> None:
    runs = [(1.0, "idle"), (2.0, "reach"), (0.5, "idle post"), (0.3, "reach post"), (0.5, "take post"), (1.0, "put")]
    runs += [(1.0, "idle"), (2.0, "squeeze"), (0.06, "reach"), (1.0, "unknown"), (2.0, "put bin"), (0.3, "release bin")]
    runs += [(1.0, "leave"), (0.4, "reach container")]
    told = [f"{act.do} {act.at}".strip() for act in acts_of(*frames_of(runs), "post")]
    assert told == ["reach thing", "take thing", "put", "squeeze", "put bin", "release"]
