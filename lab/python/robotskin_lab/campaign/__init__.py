# SPDX-License-Identifier: Apache-2.0
"""The fault campaign: random skins and faults under checkers of what must be true of the network.

In: a range of seeds. Out: what was drawn, and every invariant that broke, with the seed that repeats it. A seed draws
20 to 400 cells, 2 to 5 ports, 1 to 4 faults of the whole catalogue and at least 300 ms after the last of them. The
checkers (`invariants()`) look at every event; they share the headers of periods and frames with the firmware, and no
other code. `caught_mutants` and `sampled_fates` show that they can fail. `fresh_seed` draws seeds never used before.

`python -m robotskin_lab.campaign 17` runs seed 17 again, `--shrink` finds a smaller case, `--soak 600` runs new seeds
for ten minutes. `--sampled-mutants 200` draws as many small changes of the firmware, and lists those that live.
"""

from robotskin_lab._lab.campaign import (
    Break,
    CaseReport,
    FaultCase,
    ModelOptions,
    ModelReport,
    check_model,
    draw_case,
    invariants,
    largest_graphs,
    parse_case,
    run_case,
    shrink,
)
from robotskin_lab.campaign.mutants import MUTANTS, CampaignBuildError, CaughtMutant, caught_mutants
from robotskin_lab.campaign.mutation import Mutation
from robotskin_lab.campaign.sampled_mutants import Fate, caught_share, sampled_fates
from robotskin_lab.campaign.seeds import BrokenSeed, Distribution, SeedsReport, campaign, fresh_seed, run_seeds

__all__ = [
    "MUTANTS",
    "Break",
    "BrokenSeed",
    "CampaignBuildError",
    "CaseReport",
    "CaughtMutant",
    "Distribution",
    "Fate",
    "FaultCase",
    "ModelOptions",
    "ModelReport",
    "Mutation",
    "SeedsReport",
    "campaign",
    "caught_mutants",
    "caught_share",
    "check_model",
    "draw_case",
    "fresh_seed",
    "invariants",
    "largest_graphs",
    "parse_case",
    "run_case",
    "run_seeds",
    "sampled_fates",
    "shrink",
]
