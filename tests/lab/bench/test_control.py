# SPDX-License-Identifier: Apache-2.0
"""The benchmark of control, few rounds: its figures are measured, and those that are laws hold."""

import os
from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pytest

from robotskin.control import BEHAVIOURS
from robotskin.errors import RobotskinError, UnknownNameError
from robotskin.robots.gains import GainSet
from robotskin_lab.bench import control_collision, control_proximity, control_soak, control_spread
from robotskin_lab.bench.control import run
from robotskin_lab.bench.control_chain import without_estimates
from robotskin_lab.bench.control_peer import PYTHON_VARIABLE
from robotskin_lab.bench.control_soak import PAIRINGS, soak_figures
from robotskin_lab.bench.control_ticks import LAP, lesser_of, time_figures, timed_laps


def test_times_of_ticks_and_of_the_skin_task(seed: int) -> None:
    figures = run(seed=seed, parts="ticks,skin", ticks=150)
    assert "RobotDynamics.update" in figures["reference_kernel"]
    assert figures["reference_us"] > 0
    for key in ("talos_tick_nullspace", "talos_tick_hqp", "talos_tick_hqp_limited", "ur5_tick"):
        assert 0 < figures[f"{key}_median_us"] <= figures[f"{key}_p99_us"] <= figures[f"{key}_max_us"]
        assert figures[f"{key}_wall_median_us"] <= figures[f"{key}_wall_max_us"]
        assert figures[f"{key}_median_ratio"] == pytest.approx(figures[f"{key}_median_us"] / figures["reference_us"])
        assert figures[f"{key}_median_lap_ratio"] == pytest.approx(figures[f"{key}_median_ratio"], rel=0.5)
    assert 0 < figures["skin_task_1260_us"] < figures["skin_task_100000_us"]
    for key in [key for key in figures if key.endswith("_us") and key != "reference_us"]:
        assert f"{key.removesuffix('_us')}_ratio" in figures, "every time stands beside its ratio"


def test_a_time_without_wall_in_its_name_is_the_processors(seed: int) -> None:
    wall_us, processor_us = np.random.default_rng(seed).uniform([[500.0], [10.0]], [[900.0], [90.0]], (2, 300))
    figures = time_figures("talos_tick_hqp", np.column_stack([wall_us, processor_us]))
    assert figures["talos_tick_hqp_p99_us"] == pytest.approx(np.percentile(processor_us, 99))
    assert figures["talos_tick_hqp_max_us"] == processor_us.max()
    assert figures["talos_tick_hqp_wall_p99_us"] == pytest.approx(np.percentile(wall_us, 99))
    assert figures["talos_tick_hqp_wall_max_us"] == wall_us.max()


def test_a_tick_is_compared_with_the_machine_as_fast_as_it_was_around_it(seed: int) -> None:
    ticks = 3 * LAP + 7
    references_us = np.random.default_rng(seed).uniform(5.0, 50.0, 5)
    coming = iter(references_us)
    around = iter(np.repeat((references_us[:-1] + references_us[1:]) / 2, 2))  # a lap, and the ticks before it
    times = timed_laps(lambda steps: np.full((steps, 2), [40.0, 30.0]) * next(around), lambda: next(coming), ticks)
    assert times.shape == (ticks, 4)
    assert np.ptp(times[:, 1]) > 0
    np.testing.assert_allclose(times[:, 2:], np.full((ticks, 2), [40.0, 30.0]))


def test_of_two_runs_the_lesser_time_counts_with_its_own_ratio() -> None:
    first = np.array([[9.0, 5.0, 0.9, 0.5], [8.0, 4.0, 0.8, 0.1]])
    again = np.array([[7.0, 4.0, 0.7, 0.6], [9.0, 9.0, 9.0, 9.0]])
    np.testing.assert_array_equal(lesser_of(first, again), [[9.0, 4.0, 0.9, 0.6], [8.0, 4.0, 0.8, 0.1]])


def test_the_flat_programme_and_its_peer(seed: int) -> None:
    figures = run(seed=seed, parts="peer", ticks=50)
    assert 0 < figures["flat_qp_tick_median_us"] <= figures["flat_qp_tick_max_us"]
    assert figures["flat_qp_limited_share"] > 0.5
    if os.environ.get(PYTHON_VARIABLE):
        assert figures["flat_qp_tsid_difference"] < 1e-3
    else:
        assert not any("tsid" in key for key in figures), "what was not measured is absent"


def test_a_peer_that_cannot_run_is_an_error(tmp_path: Path) -> None:
    with pytest.raises(RobotskinError, match="no-python"):
        run(parts="peer", ticks=2, tsid_python=str(tmp_path / "no-python"))


def test_priorities_and_switches_keep_their_laws(seed: int) -> None:
    figures = run(seed=seed, parts="priority,switch", states=200)
    assert figures["priority_states"] == 200
    assert figures["priority_leak"] <= 1e-6
    assert figures["static_leak"] <= 1e-9
    assert figures["priority_leak_singular_over_bound"] <= 1e-6
    assert figures["hqp_leak_over_tolerance"] <= 10
    assert figures["switch_jump_nm"] <= 1e-3
    assert figures["switch_slope_ok"] == 1


def test_a_hand_pushes_no_harder_than_the_joints_bear_by_then(monkeypatch: pytest.MonkeyPatch) -> None:
    bears, pushed, stepped = [12.0, 9.0, 4.0, 7.0], [], []
    session = SimpleNamespace(
        in_world=lambda cell: cell,
        world=SimpleNamespace(
            push=lambda cell, force_n: pushed.append((cell, force_n)), release=lambda: pushed.append((-1, 0.0))
        ),
        run=stepped.append,
    )
    monkeypatch.setattr(control_soak, "bearable_force", lambda _session, _cell: bears[len(pushed)])
    control_soak.touch(session, 5, 8.0, 4 * control_soak.LOOK_S)  # type: ignore[arg-type]
    assert pushed == [(5, 8.0), (5, 8.0), (5, 4.0), (5, 7.0), (-1, 0.0)]
    assert sum(stepped) == pytest.approx(4 * control_soak.LOOK_S)


def test_behaviours_bear_touches_through_the_whole_chain(seed: int) -> None:
    figures = soak_figures(seed, 2.0, PAIRINGS[:1], list(BEHAVIOURS)[:2])
    assert figures["soak_s"] == pytest.approx(4.0)
    assert figures["soak_touches"] >= 2
    assert figures["soak_violations"] == 0
    assert figures["soak_stops"] == 0


def test_a_robot_that_feels_meets_a_post_more_softly_with_one_cell(seed: int) -> None:
    with_skin, share = control_collision.meet(seed, "velocity", True)
    without, _ = control_collision.meet(seed, "velocity", False)
    assert with_skin < 0.6 * without
    assert share > 0.8, "the rest is what the soft layer carries to the neighbours"


def test_a_robot_draws_back_from_a_dark_ball(seed: int) -> None:
    touched, gap_m, retreat_m = control_proximity.come(seed, "position", 0.4)
    assert not touched
    assert gap_m > 0
    assert retreat_m > 0.02


def test_answers_spread_more_where_friction_is_not_estimated(seed: int) -> None:
    gains = GainSet.load("ur5")
    interfaces = ("position", "torque")
    whole = control_spread.spreads(seed, 1, gains, interfaces, (15.0,))
    bare = control_spread.spreads(seed, 1, without_estimates(gains), interfaces, (15.0,))
    assert whole.shape == bare.shape == (1, 2)
    assert whole.max() < 0.1
    assert bare.max() > whole.max()


def test_a_part_that_is_none_is_refused() -> None:
    with pytest.raises(UnknownNameError, match="priority"):
        run(parts="priorty")
