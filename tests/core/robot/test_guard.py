# SPDX-License-Identifier: Apache-2.0
"""The last word before the robot: its table case by case, and what it lets through."""

import itertools
from pathlib import Path

import numpy as np
import pytest
from guard_bench import PERIOD_NS, Bench

from robotskin import robots
from robotskin.cycle import (
    Condition,
    Guard,
    GuardError,
    GuardLimits,
    Reason,
    SafetyState,
    next_transition,
    reason_text,
    safety_table,
)
from robotskin.model import CommandMode, RobotModel
from robotskin.skin import Health

POSITION, VELOCITY, TORQUE = CommandMode.position, CommandMode.velocity, CommandMode.torque
MODES = [POSITION, VELOCITY, TORQUE]
OFF, READY, RUNNING, DEGRADED, STOPPED = SafetyState
ALL = sum(condition.value for condition in Condition)


def without(*missing: Condition) -> int:
    return ALL & ~sum(condition.value for condition in missing)


@pytest.mark.parametrize(
    ("state", "conditions", "follows", "reason"),
    [
        (OFF, ALL, READY, Reason.none),
        (OFF, without(Condition.joints_fresh), None, None),
        (READY, ALL, RUNNING, Reason.none),
        (READY, without(Condition.wanted), None, None),
        (READY, without(Condition.joints_fresh), OFF, Reason.joints_stale),
        *[
            (READY, without(missing), None, None)
            for missing in (
                Condition.skin_fresh,
                Condition.joints_inside,
                Condition.command_finite,
                Condition.on_time,
                Condition.wanted,
                Condition.contact_within,
            )
        ],
        *[
            (state, without(missing), STOPPED, reason)
            for state in (RUNNING, DEGRADED)
            for missing, reason in (
                (Condition.joints_fresh, Reason.joints_stale),
                (Condition.joints_inside, Reason.joints_beyond),
                (Condition.skin_fresh, Reason.skin_lost),
                (Condition.command_finite, Reason.command_not_finite),
                (Condition.on_time, Reason.overrun),
                (Condition.wanted, Reason.asked),
                (Condition.contact_within, Reason.body_limit),
            )
        ],
        (RUNNING, ALL, None, None),
        (RUNNING, without(Condition.at_rest), None, None),
        (RUNNING, without(Condition.skin_whole), DEGRADED, Reason.skin_partly_lost),
        (DEGRADED, without(Condition.skin_whole), None, None),
        (DEGRADED, ALL, RUNNING, Reason.none),
        (STOPPED, ALL, None, None),
        (STOPPED, without(Condition.wanted, Condition.at_rest), None, None),
        (STOPPED, without(Condition.wanted, Condition.joints_fresh), None, None),
        (STOPPED, without(Condition.wanted), READY, Reason.none),
    ],
)
def test_a_row_of_the_table(state, conditions, follows, reason) -> None:
    expected = None if follows is None else (follows, reason)
    assert next_transition(state, conditions) == expected


def test_whatever_the_conditions_nothing_unsafe_runs_and_no_stop_is_skipped() -> None:
    needed = (
        Condition.joints_fresh,
        Condition.joints_inside,
        Condition.skin_fresh,
        Condition.command_finite,
        Condition.contact_within,
    )
    for state, conditions in itertools.product(SafetyState, range(ALL + 1)):
        row = next_transition(state, conditions)
        following = state if row is None else row[0]
        if following in (RUNNING, DEGRADED):
            assert all(conditions & condition.value for condition in (*needed, Condition.on_time, Condition.wanted))
            assert state in (READY, RUNNING, DEGRADED)
        if state in (RUNNING, DEGRADED):
            assert following in (RUNNING, DEGRADED, STOPPED)


@pytest.fixture
def bench(ur5) -> Bench:
    return Bench(ur5)


@pytest.mark.parametrize("mode", MODES)
def test_a_sound_command_passes_unchanged(bench, mode) -> None:
    bench.started(mode)
    value = bench.neutral(mode) + 1e-6
    report = bench.check(mode, value)
    np.testing.assert_array_equal(bench.command.value, value)
    assert report.send
    assert report.interventions == 0
    assert report.violations == 0


@pytest.mark.parametrize("mode", MODES)
def test_random_commands_leave_within_every_limit(ur5, seed, mode) -> None:
    bench = Bench(ur5).started(mode)
    rng = np.random.default_rng(seed)
    period = bench.limits.period_s
    last = bench.command.value.copy()
    speed = np.zeros(6)
    for _ in range(500):
        report = bench.check(mode, rng.normal(0, 1, 6) * 10.0 ** rng.uniform(-3, 5))
        value = bench.command.value.copy()
        assert report.state == RUNNING
        if mode == TORQUE:
            assert (np.abs(value) <= ur5.effort_limit).all()
            assert (np.abs(value - last) <= 20000 * period + 1e-9).all()
        else:
            now = (value - last) / period if mode == POSITION else value
            assert (np.abs(now) <= 0.95 * ur5.velocity_limit + 1e-9).all()
            assert (np.abs(now - speed) <= 100 * period + 1e-6).all()
            speed = now
        if mode == POSITION:
            assert (value >= ur5.lower).all()
            assert (value <= ur5.upper).all()
            bench.joints.position = value
        last = value
    assert report.interventions > 300


@pytest.mark.parametrize("mode", MODES)
@pytest.mark.parametrize(
    ("fault", "reason"),
    [
        ("stale joints", Reason.joints_stale),
        ("joints from the future", Reason.joints_stale),
        ("joint that is not a number", Reason.joints_stale),
        ("joint beyond its limit", Reason.joints_beyond),
        ("joint too fast", Reason.joints_beyond),
        ("old snapshot", Reason.skin_lost),
        ("cells not alive", Reason.skin_lost),
        ("command not a number", Reason.command_not_finite),
        ("controller without answer", Reason.command_not_finite),
        ("late cycle", Reason.overrun),
        ("not wanted", Reason.asked),
    ],
)
def test_a_fault_stops_the_robot_and_says_why(bench, mode, fault, reason) -> None:
    bench.started(mode)
    value, wanted, finite = bench.neutral(mode), True, True
    if fault == "stale joints":
        bench.joints_age_ns = bench.limits.joints_timeout_ns + 1
    elif fault == "joints from the future":
        bench.joints_age_ns = -10_000_001
    elif fault == "joint that is not a number":
        bench.joints.velocity[2] = np.nan
    elif fault == "joint beyond its limit":
        bench.joints.position[2] = bench.robot.upper[2] + bench.limits.end_tolerance + 0.001
    elif fault == "joint too fast":
        bench.joints.velocity[2] = -bench.robot.velocity_limit[2] - 0.001
    elif fault == "old snapshot":
        bench.skin_age_ns = bench.limits.skin_timeout_ns + 1
    elif fault == "cells not alive":
        bench.skin.health[:60] = Health.stale.value
    elif fault == "command not a number":
        value[1] = np.nan
    elif fault == "controller without answer":
        finite = False
    elif fault == "late cycle":
        bench.now_ns += bench.limits.largest_cycle_ns
    else:
        wanted = False
    report = bench.check(mode, value, wanted, finite)
    assert (report.state, report.reason) == (STOPPED, reason)
    blind = reason == Reason.joints_stale
    assert (report.send, report.stop_port) == (not blind, blind)
    if report.send:
        assert np.isfinite(bench.command.value).all()


def test_a_command_that_was_held_back_closes_up_without_swinging(ur5) -> None:
    """The controller's command stops at once from 0.5 rad/s, which takes the joint 25 ms at 20 rad/s²."""
    bench = Bench(ur5)
    bench.limits = GuardLimits([20.0] * 6, [10.0] * 6, [20000.0] * 6)
    bench.guard = Guard(ur5, bench.limits)
    bench.started(POSITION)
    asked, ahead = bench.joints.position.copy(), []
    for tick in range(400):
        asked[0] += 0.5e-3 if tick < 200 else 0.0
        bench.check(POSITION, asked)
        bench.joints.position = bench.command.value.copy()
        ahead.append(bench.command.value[0] - asked[0])
    np.testing.assert_allclose(ahead[150:200], 0, atol=1e-9)
    after = np.array(ahead[200:])
    assert after.max() <= 0.5**2 / (2 * 20) + 0.5e-3
    assert after.min() >= -1e-4, "it does not swing beyond the command"
    assert np.abs(after[120:]).max() <= 1e-9


def test_silence_of_cells_that_are_alive_is_no_fault(bench) -> None:
    bench.started(POSITION)
    bench.skin.stamp_ns[:] = 0
    for _ in range(1000):
        report = bench.check(POSITION, bench.neutral(POSITION))
    assert report.state == RUNNING


def test_missing_cells_make_the_robot_slow(bench) -> None:
    bench.started(VELOCITY)
    bench.skin.health[:20] = Health.dead.value
    for _ in range(500):
        report = bench.check(VELOCITY, np.full(6, 3.0))
    assert (report.state, report.reason) == (DEGRADED, Reason.skin_partly_lost)
    np.testing.assert_allclose(bench.command.value, 0.25 * bench.robot.velocity_limit)
    bench.skin.health[:] = Health.alive.value
    assert bench.check(VELOCITY, np.zeros(6)).state == RUNNING


@pytest.mark.parametrize("mode", [POSITION, VELOCITY])
def test_a_stop_decelerates_and_then_holds(bench, mode) -> None:
    bench.started(mode)
    period, speed = bench.limits.period_s, 0.0
    for _ in range(100):  # speeds up to 0.5 rad/s
        speed = min(0.5, speed + 0.05)
        value = bench.joints.position + speed * period if mode == POSITION else np.full(6, speed)
        bench.check(mode, value)
        bench.joints.position = bench.joints.position + speed * period
        bench.joints.velocity[:] = speed
    places = [bench.joints.position.copy()]
    for _ in range(200):
        report = bench.check(mode, value, wanted=True, finite=False)
        assert report.state == STOPPED
        assert report.send
        now = (bench.command.value - places[-1]) / period if mode == POSITION else bench.command.value
        assert (now >= -1e-9).all()
        assert (speed - now <= 10 * period + 1e-6).all()
        speed = now
        places.append(places[-1] + now * period)
        bench.joints.position, bench.joints.velocity = places[-1], now
    np.testing.assert_allclose(speed, 0, atol=1e-9)
    np.testing.assert_allclose(places[-1] - places[0], 0.5**2 / (2 * 10), rtol=0.1)


def test_a_torque_controlled_robot_is_braked_and_held(bench) -> None:
    bench.started(TORQUE)
    bench.joints.velocity[:] = [0.5, -0.3, 0.4, 0.2, 0.0, 0.1]
    period = bench.limits.period_s
    for _ in range(1000):
        bench.check(TORQUE, np.zeros(6), finite=False)
        acceleration = bench.dynamics.forward_dynamics(bench.command.value.copy())
        bench.joints.velocity = bench.joints.velocity + period * acceleration
        bench.joints.position = bench.joints.position + period * bench.joints.velocity
    np.testing.assert_allclose(bench.joints.velocity, 0, atol=1e-3)
    np.testing.assert_allclose(bench.command.value, bench.dynamics.gravity_torque, atol=0.1)


def test_a_stop_ends_only_when_a_run_is_not_wanted(bench) -> None:
    bench.started(POSITION)
    bench.check(POSITION, bench.neutral(POSITION), finite=False)
    for _ in range(100):
        assert bench.check(POSITION, bench.neutral(POSITION)).state == STOPPED
    assert bench.check(POSITION, bench.neutral(POSITION), wanted=False).state == READY
    assert bench.check(POSITION, bench.neutral(POSITION)).state == RUNNING


@pytest.mark.parametrize("mode", [POSITION, VELOCITY])
def test_a_servo_that_overshoots_stays_within_its_velocity_limit(bench, mode) -> None:
    """A servo cannot stop accelerating at once: a command that ends its climb at the limit carries it beyond."""
    bench.started(mode)
    limit = bench.robot.velocity_limit[0]
    frequency, damping, step = 150.0, 0.4, bench.limits.period_s / 20
    was, speed, acceleration = bench.joints.position[0], 0.0, 0.0
    for _ in range(300):
        asked = bench.neutral(mode)
        asked[0] = was + 1.0 if mode == POSITION else 10.0
        bench.check(mode, asked)
        commanded = bench.command.value[0]
        if mode == POSITION:
            commanded, was = (commanded - was) / bench.limits.period_s, commanded
        for _ in range(20):
            acceleration += step * (frequency**2 * (commanded - speed) - 2 * damping * frequency * acceleration)
            speed += step * acceleration
        assert speed <= limit
    assert speed > 0.9 * limit


def test_what_a_joints_damping_makes_slow_is_not_held_back() -> None:
    """A wrist of 20 Nm s/rad turns at 0.75 rad/s by 15 Nm, for all its little inertia; its shoulder can be too fast."""
    model = RobotModel(robots.load("ur5").urdf.replace('damping="0.0"', 'damping="20.0"'))
    assert (np.asarray(model.joint_damping) == 20).all()
    bench = Bench(model).started(TORQUE)
    push, period = np.zeros(6), bench.limits.period_s
    for joint, torque, interventions in ((5, 15.0, False), (0, 140.0, True)):
        push[joint] = torque
        before = bench.guard.report.interventions
        for _ in range(1000):
            report = bench.check(TORQUE, bench.neutral(TORQUE) + push)
            damped = bench.dynamics.mass_matrix + 20 * period * np.eye(6)
            force = bench.command.value - bench.dynamics.nonlinear_effects - 20 * bench.joints.velocity
            bench.joints.velocity = bench.joints.velocity + period * np.linalg.solve(damped, force)
            assert (np.abs(bench.joints.velocity) <= model.velocity_limit).all()
        assert (report.interventions > before) == interventions
    assert bench.joints.velocity[5] == pytest.approx(0.75, rel=0.05)
    assert report.state == RUNNING


@pytest.mark.parametrize("mode", MODES)
def test_no_joint_runs_into_its_limit(bench, mode) -> None:
    """A controller that pushes the elbow towards its limit for ever stops before it."""
    bench.joints.position[2] = 2.9
    bench.started(mode)
    period, limit = bench.limits.period_s, bench.robot.upper[2]
    for _ in range(2000):
        push = {POSITION: bench.joints.position.copy(), VELOCITY: np.zeros(6), TORQUE: bench.neutral(TORQUE)}[mode]
        push[2] = {POSITION: 4.0, VELOCITY: 3.0, TORQUE: push[2] + 10.0}[mode]
        report = bench.check(mode, push)
        value = bench.command.value.copy()
        if mode == TORQUE:
            bench.joints.velocity = bench.joints.velocity + period * bench.dynamics.forward_dynamics(value)
        elif mode == VELOCITY:
            bench.joints.velocity = value
        else:
            bench.joints.velocity = (value - bench.joints.position) / period
        bench.joints.position = bench.joints.position + period * bench.joints.velocity
        assert bench.joints.position[2] <= limit
    assert report.violations == 0
    assert report.state == RUNNING


def test_a_measured_state_beyond_a_limit_is_a_violation_once_a_measurement(bench) -> None:
    bench.started(POSITION)
    bench.joints.effort[1] = bench.robot.effort_limit[1] + 1
    assert bench.check(POSITION, bench.neutral(POSITION)).violations == 1
    bench.joints_age_ns += PERIOD_NS  # the same measurement again
    assert bench.check(POSITION, bench.neutral(POSITION)).violations == 1
    bench.joints.effort[1] = 0
    assert bench.check(POSITION, bench.neutral(POSITION)).violations == 1


def test_limits_that_do_not_fit_are_refused(ur5) -> None:
    with pytest.raises(GuardError, match="acceleration has 5 values, the robot has 6 joints"):
        Guard(ur5, GuardLimits([1.0] * 5, [1.0] * 6, [1.0] * 6))
    with pytest.raises(GuardError, match="torque_rate -1"):
        Guard(ur5, GuardLimits([1.0] * 6, [1.0] * 6, [-1.0] * 6))
    limits = GuardLimits([1.0] * 6, [1.0] * 6, [1.0] * 6)
    limits.smallest_alive_share = 0.95
    with pytest.raises(GuardError, match=r"smallest_alive_share is 0\.95"):
        Guard(ur5, limits)
    for name, value in (("joints_timeout_ns", 0), ("skin_timeout_ns", 2 * 10**9), ("largest_cycle_ns", -1)):
        limits = GuardLimits([1.0] * 6, [1.0] * 6, [1.0] * 6)
        setattr(limits, name, value)
        with pytest.raises(GuardError, match=f"{name} is {value}"):
            Guard(ur5, limits)


def test_the_page_shows_the_table() -> None:
    """docs/control.md, row by row: state, what holds, what does not, state that follows, reason."""
    page = (Path(__file__).parents[3] / "docs" / "control.md").read_text()
    written = [
        tuple(cell.strip() for cell in line.strip("|").split("|"))
        for line in page.partition("| state | if |")[2].partition("\n\n")[0].splitlines()[2:]
    ]

    def names(bits: int) -> str:
        return ", ".join(f"`{condition.name}`" for condition in Condition if bits & condition.value)

    table = [
        (state.name, names(all_of), names(none_of), follows.name, "" if reason == Reason.none else reason_text(reason))
        for state, all_of, none_of, follows, reason in safety_table()
    ]
    assert written == table
