# SPDX-License-Identifier: Apache-2.0
"""Random touches on a standing robot through firmware, network and driver; what falls, stops and limits are counted."""

from types import SimpleNamespace

import pytest

from robotskin.session import SafetyState
from robotskin.session.touches import is_reached
from robotskin_lab.bench import balance_chain_touches
from robotskin_lab.bench.balance_chain_touches import TouchedSession, chain_touch_figures

FOREARM_CELL, STRONG_N = 591, 31.0
HEAD_CELL, OVERPOWERS_N = 527, 36.4
"""A hand slips aside on the head, and turns the neck by a lever several times that of the cell."""
COVERED_CELL = 81
"""Of the pelvis, behind an arm. A hand that is put in front of it lies inside of the robot, and pushes with 900 N."""


def test_a_strong_touch_ends_and_no_motor_is_overdriven_for_the_hand_eases_in_time(seed: int) -> None:
    robot = TouchedSession(seed)
    try:
        robot.touch(FOREARM_CELL, STRONG_N, 1.1)
        robot.run(0.4)
        assert robot.session.state is SafetyState.running, robot.session.why_not_running()
        assert robot.violations == 0
        assert not robot.fallen
        assert robot.eased == 0
        assert is_reached(robot.session, FOREARM_CELL)
        assert not is_reached(robot.session, COVERED_CELL)

        robot.touch(HEAD_CELL, OVERPOWERS_N, 1.2)
        robot.run(0.4)
        assert robot.eased == 1
        assert robot.session.state is SafetyState.running, robot.session.why_not_running()
        assert robot.violations == 0

        robot.session.world.step(0.020)  # control was late: the guard stops it
        robot.run(0.1)
        assert robot.session.state is SafetyState.stopped
        robot.start_if_stopped()
        assert robot.stops == 1
        assert robot.session.state is SafetyState.running, robot.session.why_not_running()
    finally:
        robot.end()


def test_after_a_fall_another_robot_is_touched_until_the_time_is_over(
    seed: int, monkeypatch: pytest.MonkeyPatch
) -> None:
    made: list[SimpleNamespace] = []

    class Touched:
        def __init__(self, seed: int) -> None:
            self.number, self.fallen, self.stops, self.violations = len(made), False, 1, 10
            self.eased = 2
            self.closest_m = 0.04 - 0.01 * self.number
            self.ended = False
            self.session = SimpleNamespace(world=SimpleNamespace(time_s=3.0))
            made.append(self)  # type: ignore[arg-type]

        def touch(self, cell: int, force_n: float, seconds: float) -> None:
            assert 5.0 <= force_n <= 40.0
            self.session.world.time_s += 1.0

        def run(self, seconds: float) -> None:
            self.fallen = self.number == 0 and self.session.world.time_s > 6.5

        def start_if_stopped(self) -> None:
            pass

        def end(self) -> None:
            self.ended = True

    looks = iter(range(1000))
    monkeypatch.setattr(balance_chain_touches, "TouchedSession", Touched)
    monkeypatch.setattr(balance_chain_touches, "is_reached", lambda _session, _cell: next(looks) % 3 > 0)
    figures = chain_touch_figures(seed, 9.0)
    assert len(made) == 2
    assert all(robot.ended for robot in made)
    assert figures == {
        "chain_touch_falls": 1.0,
        "chain_touch_stops_max": 2.0,
        "chain_touch_limit_violations": 20.0,
        "chain_touch_closest_mm": pytest.approx(30.0),
        "chain_touch_s": pytest.approx(9.0),
        "chain_touches": 9.0,
        "chain_touches_eased": 4.0,
        "chain_touches_covered": 5.0,
    }


def test_the_world_of_a_robot_that_has_fallen_is_run_no_more() -> None:
    done: list[str] = []
    robot = object.__new__(FallenSession)
    port = SimpleNamespace(stop=lambda: done.append("stop"))
    robot.session = SimpleNamespace(world=SimpleNamespace(port=port), shut_down=lambda: done.append("run"))  # type: ignore[assignment]
    robot.end()
    assert done == ["stop"]


class FallenSession(TouchedSession):
    fallen = True  # type: ignore[assignment]
