# SPDX-License-Identifier: Apache-2.0
"""Blows on a standing robot through firmware, network and driver: what the hand brings, and what is counted."""

from types import SimpleNamespace

import numpy as np
import pytest

from robotskin.session import SafetyState
from robotskin_lab.bench import blows
from robotskin_lab.bench.balance_cells import inner_cells, worn_by_robot
from robotskin_lab.bench.balance_chain_touches import TouchedSession
from robotskin_lab.bench.balance_drawn import touched_links
from robotskin_lab.bench.balance_rig import CHEST


def middle_cell(link: str) -> int:
    cells = inner_cells(link)
    return int(cells[len(cells) // 2])


def test_a_hand_brings_the_half_sine_that_it_is_asked_for_and_the_robot_goes_on(seed: int) -> None:
    robot = TouchedSession(seed)
    asked = (4.0, CHEST, 1e9), (10.0, CHEST, 1e9), (10.0, "arm_right_5_link", 0.5)
    try:
        for impulse_ns, link, share in asked:
            blow = blows.strike(robot, middle_cell(link), "", blows.peak_of(impulse_ns), share)
            assert blow is not None
            assert blow.lighter == (share < 1.0)
            assert blow.asked_ns == pytest.approx(impulse_ns) or blow.lighter
            assert 0.85 * blow.asked_ns < blow.brought_ns < 1.1 * blow.asked_ns
            assert 0.85 < blow.peak_over_asked < 1.3
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


def test_each_link_that_is_struck_belongs_to_a_part() -> None:
    parts = {link: blows.part_of(link) for link in touched_links(worn_by_robot())}
    assert set(parts.values()) == set(blows.PARTS)
    assert parts[CHEST] == "trunk"
    assert parts["arm_left_3_link"] == "upper_arm"
    assert parts["arm_left_4_link"] == "forearm"


class Pressed:
    """A robot that keeps still: a hand on it presses with what it is asked for, and bodies are near during blows."""

    def __init__(self, *, comes: bool) -> None:
        self.comes, self.force_n, self.fallen, self.closest_m, self.released = comes, 0.0, False, 0.05, False
        self.session = SimpleNamespace(world=self)

    def push(self, cell: int, force_n: float) -> None:
        self.force_n = force_n

    def contact_normal_force(self) -> list[float]:
        return [self.force_n if self.comes else 0.0]

    def run(self, seconds: float) -> None:
        if self.force_n > blows.TOUCH_N:
            self.closest_m = 0.03

    def release(self) -> None:
        self.released = True


def test_bodies_are_looked_at_during_a_blow_and_a_hand_that_does_not_come_strikes_not(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    monkeypatch.setattr(blows, "bearable_force", lambda _session, _cell, share: 80.0 * share)
    robot = Pressed(comes=True)
    blow = blows.strike(robot, 0, "head", 100.0, 0.5)  # type: ignore[arg-type]
    assert blow is not None
    assert blow.lighter
    assert blow.asked_ns == pytest.approx(40.0 * 2 * blows.BLOW_S / np.pi)
    assert robot.closest_m == 0.03
    away = Pressed(comes=False)
    assert blows.strike(away, 0, "head", 100.0, 0.5) is None  # type: ignore[arg-type]
    assert away.released
    assert away.closest_m == 0.05


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
            self.fallen |= self.number == 0 and self.session.world.time_s > 6.5
            # The second one falls after its last blow.
            self.fallen |= self.number == 1 and seconds == blows.AFTER_S

        def start_if_stopped(self) -> None:
            pass

        def end(self) -> None:
            self.ended = True

    count = 0

    def strike(robot: Struck, cell: int, part: str, peak_n: float, share: float) -> blows.Blow | None:
        nonlocal count
        robot.session.world.time_s += 1.0
        count += 1
        if count == 2:
            return None
        return blows.Blow("trunk", 5.0, 1.0 if count == 3 else 2.0 + 2.0 * (count % 2), 1.0 + count, count == 5)

    looks = iter(range(1000))
    monkeypatch.setattr(blows, "TouchedSession", Struck)
    monkeypatch.setattr(blows, "strike", strike)
    monkeypatch.setattr(blows, "is_reached", lambda _session, _cell: next(looks) % 3 > 0)
    figures = blows.run(seed=seed, seconds=9.0)
    assert len(made) == 2
    assert all(robot.ended for robot in made)
    assert figures.pop("processor_s") >= 0.0
    assert figures == {
        "blow_falls": 2.0,
        "blow_stops_max": 2.0,
        "blow_limit_violations": 20.0,
        "blow_closest_mm": pytest.approx(30.0),
        "blow_s": pytest.approx(9.0),
        "blows": 4.0,
        "blows_lighter": 1.0,
        "blows_from_4_ns": 4.0,
        "blows_missed": 5.0,
        "blows_covered": 5.0,
        "blow_median_ns": 4.0,
        "blow_largest_trunk_ns": 4.0,
        "blow_largest_upper_arm_ns": 0.0,
        "blow_largest_forearm_ns": 0.0,
        "blow_largest_head_ns": 0.0,
        "blow_peak_over_asked_max": 10.0,
    }
