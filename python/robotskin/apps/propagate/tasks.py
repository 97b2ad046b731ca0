# SPDX-License-Identifier: Apache-2.0
"""The behaviour of the application, the same with limbs that hand nothing on, and the robots that it fits."""

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
from robotskin.robots import Robot
from robotskin.robots.gains import ChosenGains
from robotskin.session import Session, SessionError

WITH = "propagated_compliance"
WITHOUT = "arms_alone"


def carrying_limb(robot: Robot) -> Limb:
    """The limb that carries most others: a base, or a torso.

    Raises SessionError where no limb carries another, and where the base cannot be commanded.
    """
    limbs = limbs_of(robot.core)
    parents = [one.parent for one in limbs if one.parent]
    if not parents:
        raise SessionError(
            f"propagate with {robot.name}: no limb of it carries another; use dual_arm, or a robot "
            "whose file in robots/limbs names limbs and parents"
        )
    found = max((one for one in limbs if one.name in parents), key=lambda one: parents.count(one.name))
    passive = [name for name in found.joints if not robot.core.actuated(robot.joint_index(name))]
    if passive:
        raise SessionError(f"propagate with {robot.name}: no motor moves {passive[0]}; use dual_arm")
    return found


def use_arms_alone(session: Session) -> None:
    """Let the limbs that are carried comply by themselves: what carries them is no limb, and stays where it is."""
    limbs = limbs_of(session.controller.robot)
    carrying = {one.parent for one in limbs}
    arms = [Limb(one.name, one.joints, "", one.largest_acceleration) for one in limbs if one.name not in carrying]

    def make(library: TaskLibrary, gains: ChosenGains) -> Task:
        return propagated_compliance(library, gains, arms, PropagationGains())

    session.controller.library.add(WITHOUT, make)
    tasks = {WITHOUT: 0, "gravity": FEEDFORWARD}
    meaning = "gives way with its arms; the base stays"
    session.controller.use(Behaviour(WITHOUT, tasks, Fusion.weighted_sum, meaning, gains="skin_compliance"))
