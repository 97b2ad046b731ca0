# SPDX-License-Identifier: Apache-2.0
"""The behaviour of the application, and the same with arms that hand nothing on to the base."""

from __future__ import annotations

from robotskin.control import (
    FEEDFORWARD,
    Behaviour,
    Fusion,
    Limb,
    PropagationGains,
    Task,
    TaskLibrary,
    limbs_of,
    propagated_compliance,
)
from robotskin.robots.gains import ChosenGains
from robotskin.session import Session

WITH = "propagated_compliance"
WITHOUT = "arms_alone"
BASE = "base"


def use_arms_alone(session: Session) -> None:
    """Let the session's arms comply by themselves: the base is no limb, and stays where it is."""
    arms = [
        Limb(one.name, one.joints, "", one.largest_acceleration)
        for one in limbs_of(session.controller.robot)
        if one.name != BASE
    ]

    def make(library: TaskLibrary, gains: ChosenGains) -> Task:
        return propagated_compliance(library, gains, arms, PropagationGains())

    session.controller.library.add(WITHOUT, make)
    tasks = {WITHOUT: 0, "gravity": FEEDFORWARD}
    meaning = "gives way with its arms; the base stays"
    session.controller.use(Behaviour(WITHOUT, tasks, Fusion.weighted_sum, meaning, gains="skin_compliance"))
