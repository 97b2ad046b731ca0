# SPDX-License-Identifier: Apache-2.0
"""Commands whose solver steps were cut keep every limit, and the torque does not step where the cut begins or ends."""

from robotskin_lab.bench.control_fallback import fallback_figures


def test_cut_ticks_keep_the_limits_and_the_torque(seed: int) -> None:
    figures = fallback_figures(seed, 40)
    assert figures["fallback_cut_ticks"] > 500
    assert figures["fallback_limit_violations"] == 0
    assert figures["fallback_states_widened_needlessly"] == 0
    assert figures["fallback_jump_nm"] <= 1e-3
    assert figures["fallback_level_error"] < 0.02


def test_a_bound_that_the_first_torque_nearly_meets_is_not_moved() -> None:
    """In one of these states torque and acceleration seem to exclude each other; the first all but meets a bound."""
    figures = fallback_figures(11, 500)
    assert figures["fallback_states_widened"] == 0
    assert figures["fallback_limit_violations"] == 0
