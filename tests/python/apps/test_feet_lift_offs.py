# SPDX-License-Identifier: Apache-2.0
"""What is counted of lift-offs that were told: late, missed, false, taken back; and feet that only settle."""

import numpy as np
import pytest

from robotskin.apps.feet.contact import LEAST_STANCE_S, Event, Felt, FootContact, State
from robotskin.apps.feet.gait import Gait
from robotskin.apps.feet.lift_offs import lift_off_figures
from robotskin.apps.feet.settings import read_settings
from robotskin.apps.feet.walk import Told

PERIOD_S = 0.004
STEPS = 40
DELAY_S = 0.024


@pytest.fixture
def gait(seed: int) -> Gait:
    return Gait(seed, STEPS)


def figures(gait: Gait, events: list[list[Event]]) -> dict[str, float]:
    """Of feet that carry 400 N whenever the gait has them on the ground."""
    time = np.arange(0, gait.ends_s + 1, PERIOD_S)
    load = np.full((len(time), 2), 400.0)
    for step in gait.steps:
        load[(time > step.lifts_s) & (time < step.lands_s), step.foot] = 0.0
    told = [Told(sorted(of_foot, key=lambda event: event.time_s)) for of_foot in events]
    return lift_off_figures(time, load, told, gait.steps)


def right(gait: Gait) -> list[list[Event]]:
    """What ought to be told."""
    return [
        [
            event
            for step in gait.steps
            if step.foot == foot
            for event in (Event(step.lifts_s + DELAY_S, "lift-off"), Event(step.lands_s + DELAY_S, "touchdown"))
        ]
        for foot in (0, 1)
    ]


def test_what_is_told_in_time_is_detected(gait: Gait) -> None:
    found = figures(gait, right(gait))
    assert found["lift_off_detected_share"] == 1
    assert found["lift_off_ms_median"] == pytest.approx(1e3 * DELAY_S, abs=1e3 * PERIOD_S)
    assert [found[key] for key in found if key.endswith(("false_share", "back_share", "wrong_share"))] == [0, 0, 0]


def test_missed_false_and_taken_back_lift_offs_are_counted(gait: Gait) -> None:
    events = right(gait)
    swing, stance = gait.steps[10], gait.steps[20].lands_s + 0.5
    events[swing.foot] = [event for event in events[swing.foot] if event.time_s != swing.lifts_s + DELAY_S]
    events[gait.steps[20].foot].append(Event(stance, "lift-off"))
    back, foot = gait.steps[30].lands_s + 0.04, gait.steps[30].foot
    events[foot] += [Event(back, "lift-off"), Event(back + 0.004, "stays")]
    found = figures(gait, events)
    assert found["lift_off_detected_share"] == pytest.approx(1 - 1 / STEPS)
    assert found["lift_off_false_share"] == pytest.approx(1 / STEPS)
    assert found["lift_off_taken_back_share"] == pytest.approx(1 / STEPS)
    assert found["stays_wrong_share"] == 0


def test_a_true_lift_off_that_is_taken_back_is_missed_and_wrong(gait: Gait) -> None:
    events, step = right(gait), gait.steps[10]
    events[step.foot].append(Event(step.lifts_s + DELAY_S + 0.12, "stays"))
    found = figures(gait, events)
    assert found["lift_off_detected_share"] == pytest.approx(1 - 1 / STEPS)
    assert found["stays_wrong_share"] == pytest.approx(1 / STEPS)


@pytest.mark.parametrize("silent_s", [0.5 * LEAST_STANCE_S, 0.9 * LEAST_STANCE_S])
def test_a_sole_that_settles_has_not_left(silent_s: float) -> None:
    # A cell meets the ground, then the pads beside it carry the load for a while.
    foot, now, events = FootContact(read_settings()), 0.0, []
    for seconds, force in [(0.5, 0.0), (0.008, 5.0), (silent_s, 0.0), (0.5, 5.0), (0.3, 0.0)]:
        for _ in range(round(seconds / PERIOD_S)):
            now += PERIOD_S
            felt = Felt(now, np.full(7, force), np.full(7, np.inf), np.zeros((7, 3)), np.ones(7, dtype=bool))
            events += [event.kind for event in foot.update(felt)]
    assert events == ["touchdown", "lift-off"]
    assert foot.state is State.SWINGS
