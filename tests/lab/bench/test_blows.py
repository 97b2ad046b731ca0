# SPDX-License-Identifier: Apache-2.0
"""Blows on a standing robot through firmware, network and driver: what the hand brings, and what is counted."""

from types import SimpleNamespace

import numpy as np
import pytest

from robotskin.session import SafetyState
from robotskin_lab.bench import blows
from robotskin_lab.bench.balance_cells import inner_cells
from robotskin_lab.bench.balance_chain_touches import TouchedSession
from robotskin_lab.bench.balance_rig import CHEST

CHEST_CELL = int(inner_cells(CHEST)[len(inner_cells(CHEST)) // 2])


def test_a_hand_brings_the_impulse_that_it_is_asked_for_and_the_robot_goes_on(seed: int) -> None:
    robot = TouchedSession(seed)
    try:
        for asked_ns in (4.0, 10.0):
            brought_ns = blows.strike(robot, CHEST_CELL, blows.peak_of(asked_ns))
            assert 0.9 * asked_ns < brought_ns < 1.1 * asked_ns
            robot.run(0.5)
        assert robot.session.state is SafetyState.running, robot.session.why_not_running()
        assert robot.violations == 0
        assert not robot.fallen
    finally:
        robot.end()


def test_a_half_sine_carries_what_it_was_made_for(seed: int) -> None:
    asked_ns = np.random.default_rng(seed).uniform(1.0, 10.0)
    times_s = np.linspace(0.0, blows.BLOW_S, 2001)
    force_n = blows.peak_of(asked_ns) * np.sin(np.pi * times_s / blows.BLOW_S)
    assert np.trapezoid(force_n, times_s) == pytest.approx(asked_ns, rel=1e-4)


def test_after_a_fall_another_robot_is_struck_until_the_time_is_over(
    seed: int, monkeypatch: pytest.MonkeyPatch
) -> None:
    made: list[SimpleNamespace] = []

    class Struck:
        def __init__(self, seed: int) -> None:
            self.number, self.fallen, self.stops, self.violations = len(made), False, 1, 10
            self.closest_m, self.ended = 0.04 - 0.01 * self.number, False
            self.session = SimpleNamespace(world=SimpleNamespace(time_s=3.0))
            made.append(self)  # type: ignore[arg-type]

        def run(self, seconds: float) -> None:
            self.fallen = self.number == 0 and self.session.world.time_s > 6.5

        def start_if_stopped(self) -> None:
            pass

        def end(self) -> None:
            self.ended = True

    struck_n: list[float] = []

    def strike(robot: Struck, cell: int, peak_n: float) -> float:
        robot.session.world.time_s += 1.0
        struck_n.append(peak_n)
        return 2.0 + 2.0 * (len(struck_n) % 2)

    looks = iter(range(1000))
    monkeypatch.setattr(blows, "TouchedSession", Struck)
    monkeypatch.setattr(blows, "strike", strike)
    monkeypatch.setattr(blows, "is_reached", lambda _session, _cell: next(looks) % 3 > 0)
    monkeypatch.setattr(blows, "bearable_force", lambda _session, _cell, share: 80.0 * share)
    figures = blows.run(seed=seed, seconds=9.0)
    assert len(made) == 2
    assert all(robot.ended for robot in made)
    assert max(struck_n) <= 40.0
    assert figures.pop("processor_s") >= 0.0
    assert figures == {
        "blow_falls": 1.0,
        "blow_stops_max": 2.0,
        "blow_limit_violations": 20.0,
        "blow_closest_mm": pytest.approx(30.0),
        "blow_s": pytest.approx(9.0),
        "blows": 9.0,
        "blows_lighter": float(sum(peak_n == 40.0 for peak_n in struck_n)),
        "blows_from_4_ns": 5.0,
        "blows_covered": 5.0,
        "blow_largest_ns": 4.0,
        "blow_median_ns": 4.0,
    }
