# SPDX-License-Identifier: Apache-2.0
"""The fault campaign: random skins and faults under checkers of what must be true of the network.

In: a range of seeds. Out: what was drawn, and every invariant that broke, with the seed that repeats it. A seed draws
20 to 400 cells, 2 to 5 ports, 1 to 4 faults of the whole catalogue and at least 300 ms after the last of them. The
checkers (`invariants()`) look at every event and share no code with the protocol. `caught_mutants` shows that they can
fail.

`python -m robotskin_lab.campaign 17` runs seed 17 again, `--shrink` finds a smaller case, `--soak 600` runs new seeds
for ten minutes.
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
from robotskin_lab.campaign.seeds import BrokenSeed, Distribution, SeedsReport, campaign, run_seeds

__all__ = [
    "MUTANTS",
    "Break",
    "BrokenSeed",
    "CampaignBuildError",
    "CaseReport",
    "CaughtMutant",
    "Distribution",
    "FaultCase",
    "ModelOptions",
    "ModelReport",
    "SeedsReport",
    "campaign",
    "caught_mutants",
    "check_model",
    "draw_case",
    "invariants",
    "largest_graphs",
    "parse_case",
    "run_case",
    "run_seeds",
    "shrink",
]
