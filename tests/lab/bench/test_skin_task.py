# SPDX-License-Identifier: Apache-2.0
"""The benchmark of the skin task, few rounds: its torques agree and its figures are measured."""

from robotskin_lab.bench.skin_task import run


def test_fast_and_literal_torques_agree(seed: int) -> None:
    figures = run(seed=seed, rounds=300)
    assert figures["cells"] == 1260
    assert figures["torque_max_nm"] > 1
    assert figures["torque_error"] <= 1e-6
    for name in ("aggregate", "product", "single", "kinematics", "naive"):
        assert 0 < figures[f"{name}_us"] <= figures[f"{name}_p99_us"] <= figures[f"{name}_max_us"]
    assert figures["naive_ratio"] > 5
