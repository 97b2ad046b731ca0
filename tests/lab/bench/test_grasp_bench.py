# SPDX-License-Identifier: Apache-2.0
"""The benchmark of grasping, one trial a part: its figures are there, and what is no part is refused."""

import pytest

from robotskin.errors import InputError, UnknownNameError
from robotskin_lab.bench.grasp import run


@pytest.mark.timeout(300)
def test_one_trial_of_each_method(seed: int) -> None:
    figures = run(
        seed=seed, parts="reactive,exact", objects="cylinder", trials=1, exact_trials=1, least_mm=6, most_mm=8
    )
    assert figures["cylinder_reactive_held"] == 1
    assert figures["cylinder_reactive_force_before_grip_n"] < figures["cylinder_exact_force_before_grip_n"]
    assert figures["cylinder_exact_undisturbed"] == 1
    assert figures["cylinder_reactive_violations"] == 0


@pytest.mark.timeout(300)
def test_a_tool_is_lifted_by_a_hand_that_is_touched_and_once_more_by_one_that_is_not(seed: int) -> None:
    figures = run(seed=seed, parts="soak", objects="pliers", soak_seconds=5.0)
    assert figures["pliers_soak_touches"] >= 2
    assert (figures["pliers_soak_violations"], figures["pliers_soak_stops"]) == (0, 0)
    assert figures["pliers_soak_goes_on"] == 1
    assert "realtime_ratio" not in figures


def test_what_was_not_tried_has_no_figure() -> None:
    figures = run(parts="primitive,exact,hold", primitive_trials=0, exact_trials=0, hold_trials=0)
    assert figures == {}


def test_what_is_none_is_refused() -> None:
    with pytest.raises(UnknownNameError, match="reactiv"):
        run(parts="reactiv")
    with pytest.raises(UnknownNameError, match="ball, cylinder, pliers"):
        run(objects="cube")
    with pytest.raises(InputError, match="within 0 to 20"):
        run(least_mm=10, most_mm=5)
