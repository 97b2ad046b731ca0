# SPDX-License-Identifier: Apache-2.0
import numpy as np

from robotskin.cycle import Limit
from robotskin.session.reasons import interventions_told


def test_the_limits_that_changed_most_commands_are_named() -> None:
    counts = np.zeros((5, 3), dtype=np.uint64)
    assert interventions_told(counts, ["a", "b", "c"]) == ""
    counts[Limit.velocity.value, 1] = 12
    counts[Limit.position.value, 2] = 40
    told = interventions_told(counts, ["a", "b", "c"])
    assert told == "position limit of c in 40 ticks, velocity limit of b in 12 ticks"
    counts[Limit.torque.value] = 1
    assert interventions_told(counts, ["a", "b", "c"]).endswith("torque limit of a in 1 tick, and 2 more")
