# SPDX-License-Identifier: Apache-2.0
"""The first session of a newcomer with an own arm, command by command, in its short form."""

from robotskin_lab.bench.newcomer import OWN_ARM, session


def test_an_own_arm_is_covered_checked_run_and_finds_itself(seed: int) -> None:
    figures = session(str(OWN_ARM), seed, cells=40, short=True)
    assert figures["intervention_share"] < 0.01
    assert figures["placed_share"] >= 0.8
