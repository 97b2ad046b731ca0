# SPDX-License-Identifier: Apache-2.0
"""What a robot that is wanted to run waits for, in words: a phrase for each condition of the guard."""

from __future__ import annotations

from robotskin.cycle import Condition

WAITS_FOR: dict[Condition, str] = {
    Condition.joints_fresh: "a fresh state of the joints",
    Condition.joints_inside: "joints within their limits",
    Condition.skin_fresh: "fresh values of enough cells",
    Condition.skin_whole: "values of nearly all cells",
    Condition.command_finite: "a finite command",
    Condition.on_time: "a cycle that comes in time",
    Condition.wanted: "being started",
    Condition.at_rest: "joints at rest",
    Condition.contact_within: "contacts within the limits of their body regions",
    Condition.balanced: "balance above its feet",
}


def waits_for(conditions: int) -> str:
    """In one sentence, for the bits of conditions that are missing; empty for none."""
    missing = [WAITS_FOR[one] for one in Condition if conditions & one.value]
    return f"it waits for {', '.join(missing)}" if missing else ""
