# SPDX-License-Identifier: Apache-2.0
"""A change of the firmware is built into a program of its own, and the campaign runs it."""

import dataclasses
import random
from pathlib import Path

from robotskin_lab.campaign.mutation import Mutation, mutations
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


def endless(workshop: Workshop) -> Mutation:
    """A change that surely builds, and to other code: the firmware stands still."""
    left_out = next(one for one in mutations(STEP, (workshop.firmware / STEP).read_text()) if one.kind == "left out")
    return dataclasses.replace(left_out, after="for (;;) {}")


def test_a_change_that_makes_the_firmware_run_forever_stands_still(seed: int) -> None:
    """By processor time: how busy the machine is makes no difference."""
    workshop = Workshop()
    assert workshop.fate(endless(workshop), 0, seed, 1, 2, {}).by == "standstill"


def test_workshops_beside_each_other_build_in_places_of_their_own() -> None:
    workshops = Workshop(), Workshop()
    programs = [workshop.build(endless(workshop), 0) for workshop in workshops]
    assert all(isinstance(program, Path) and program.is_file() for program in programs)
    assert programs[0] != programs[1]
