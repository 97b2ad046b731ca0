# SPDX-License-Identifier: Apache-2.0
"""An exoskeleton walks: cells in its soles feel each landing, and three motors on the arm tell its wearer."""

from robotskin.apps.feet.exoskeleton import SIDES
from robotskin.apps.feet.gait import Gait
from robotskin.apps.feet.script import expected_duty, figures_of, walk
from robotskin.apps.feet.settings import FILE, read_settings
from robotskin.apps.feet.walk import FeelingFeet

feet = FeelingFeet(Gait(seed=1, count=6), read_settings(FILE))
feet.on_event = lambda foot, event: print(f"{event.time_s:5.2f} s, {SIDES[foot]} foot: {event.kind}")
walked = walk(feet, feet.gait.ends_s, expected_duty(feet))  # with what is true under the soles, to compare
figures = figures_of(feet, walked, feet.gait.steps)
strongest = max(max(strength) for strength in walked.strength)
print(
    f"{figures['steps']:.0f} steps: {figures['detected_share']:.0%} of the landings felt, "
    f"{figures['latency_ms_median']:.0f} ms late; {figures['announced_share']:.0%} announced; "
    f"motors run at up to {strongest:.0%}"
)
assert figures["detected_share"] == 1
assert figures["false_share"] == 0
assert figures["latency_ms_median"] < 20
assert strongest > 0.5
