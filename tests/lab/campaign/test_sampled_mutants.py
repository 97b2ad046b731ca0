# SPDX-License-Identifier: Apache-2.0
"""A change of the firmware is built into a program of its own, and the campaign runs it."""

import dataclasses
import random
from pathlib import Path

from robotskin_lab.campaign.mutants import source_tree
from robotskin_lab.campaign.mutation import mutations
from robotskin_lab.campaign.sampled_mutants import Workshop

SOURCE = "cell/routing/moves.c"
STEP = "cell/step.c"


def test_a_change_is_linked_and_runs_seeds(seed: int) -> None:
    workshop = Workshop()
    changes = list(mutations(SOURCE, (workshop.firmware / SOURCE).read_text()))
    # Most changes build; a few are no C, or no change.
    fates = [
        workshop.fate(one, number, seed, 1, 60, {}) for number, one in enumerate(random.Random(seed).sample(changes, 3))
    ]
    assert any(fate.counts for fate in fates), [str(fate) for fate in fates]


def test_a_change_that_makes_the_firmware_run_forever_stands_still(seed: int) -> None:
    """By processor time: how busy the machine is makes no difference."""
    workshop = Workshop()
    left_out = next(one for one in mutations(STEP, (workshop.firmware / STEP).read_text()) if one.kind == "left out")
    forever = dataclasses.replace(left_out, after="for (;;) {}")
    assert workshop.fate(forever, 0, seed, 1, 2, {}).by == "standstill"


def test_workshops_beside_each_other_build_in_places_of_their_own(seed: int) -> None:
    changes = [
        one for one in mutations(STEP, (source_tree() / "firmware" / STEP).read_text()) if one.kind == "left out"
    ]
    one, other = random.Random(seed).sample(changes, 2)
    workshops = Workshop(), Workshop()
    programs = [shop.build(change, 0) for shop, change in zip(workshops, (one, other), strict=True)]
    built = [program for program in programs if isinstance(program, Path)]
    assert built, "most changes build, and not to the same code"
    assert all(program.is_file() for program in built)
    assert len({program.parent for program in built}) == len(built)
