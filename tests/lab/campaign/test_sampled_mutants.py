# SPDX-License-Identifier: Apache-2.0
"""A change of the firmware is built into a program of its own, and the campaign runs it."""

import random

from robotskin_lab.campaign.mutation import mutations
from robotskin_lab.campaign.sampled_mutants import Workshop

SOURCE = "cell/routing/moves.c"


def test_a_change_is_linked_and_runs_seeds(seed: int) -> None:
    workshop = Workshop()
    changes = list(mutations(SOURCE, (workshop.firmware / SOURCE).read_text()))
    # Most changes build; a few are no C, or no change.
    fates = [
        workshop.fate(one, number, seed, 1, 60.0, {})
        for number, one in enumerate(random.Random(seed).sample(changes, 3))
    ]
    assert any(fate.counts for fate in fates), [str(fate) for fate in fates]
