# SPDX-License-Identifier: Apache-2.0
"""Each condition of the guard has words for people."""

from robotskin.cycle import Condition
from robotskin.session.waiting_for import WAITS_FOR, waits_for


def test_each_condition_has_a_phrase_of_its_own() -> None:
    assert set(WAITS_FOR) == set(Condition)
    assert len(set(WAITS_FOR.values())) == len(WAITS_FOR)
    assert not any("_" in phrase for phrase in WAITS_FOR.values())


def test_what_is_missing_is_one_sentence() -> None:
    bits = Condition.skin_fresh.value | Condition.at_rest.value
    assert waits_for(bits) == "it waits for fresh values of enough cells, joints at rest"
    assert waits_for(0) == ""
