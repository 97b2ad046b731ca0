# SPDX-License-Identifier: Apache-2.0
"""The benchmark of control, few rounds: its figures are measured, and those that are laws hold."""

import os
from pathlib import Path

import pytest

from robotskin.control import BEHAVIOURS
from robotskin.errors import RobotskinError, UnknownNameError
from robotskin_lab.bench.control import run
from robotskin_lab.bench.control_peer import PYTHON_VARIABLE


def test_times_of_ticks_and_of_the_skin_task(seed: int) -> None:
    figures = run(seed=seed, parts="ticks,skin", ticks=150)
    assert "RobotDynamics.update" in figures["reference_kernel"]
    assert figures["reference_us"] > 0
    for key in ("talos_tick_nullspace", "talos_tick_hqp", "talos_tick_hqp_limited", "ur5_tick"):
        assert 0 < figures[f"{key}_median_us"] <= figures[f"{key}_p99_us"] <= figures[f"{key}_max_us"]
        assert figures[f"{key}_median_ratio"] == pytest.approx(figures[f"{key}_median_us"] / figures["reference_us"])
    assert 0 < figures["skin_task_1260_us"] < figures["skin_task_100000_us"]
    for key in [key for key in figures if key.endswith("_us") and key != "reference_us"]:
        assert f"{key.removesuffix('_us')}_ratio" in figures, "every time stands beside its ratio"


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


def test_every_behaviour_bears_touches_on_every_pairing(seed: int) -> None:
    figures = run(seed=seed, parts="soak", soak_seconds=0.3)
    assert figures["soak_s"] == pytest.approx(0.3 * 3 * len(BEHAVIOURS))
    assert figures["soak_violations"] == 0
    assert figures["soak_stops"] == 0


def test_a_part_that_is_none_is_refused() -> None:
    with pytest.raises(UnknownNameError, match="priority"):
        run(parts="priorty")
