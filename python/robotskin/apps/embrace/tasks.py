# SPDX-License-Identifier: Apache-2.0
"""The behaviour of an embrace: its arms follow references and give way to touch; nearness is silent where it hugs."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from robotskin.apps.embrace.arms import TRUNK
from robotskin.control import FEEDFORWARD, Behaviour, TaskLibrary
from robotskin.model import RobotModel
from robotskin.robots.gains import ChosenGains, GainSet, give_share
from robotskin.session import SkinnedRobot
from robotskin.tasks import BalanceGains, BalanceTask, Fusion, JointTask, SkinReactionTask, Task

EMBRACE, EMBRACE_SKIN, EMBRACE_BALANCE = "embrace", "embrace_skin", "embrace_balance"
BANDWIDTH_HZ = 5.0
"""Of the reaction to touch. Arms that press a heavy body from two sides swing with it if they answer faster."""
LEAN = 0.0
"""Share of a lasting push that leaning takes up."""


def use_embrace(
    session: SkinnedRobot,
    allowed: NDArray[np.bool_],
    posture: NDArray[np.float64],
    compliance_share: float,
    *,
    skin: bool = True,
) -> JointTask:
    """Let the robot embrace; returns the task that takes the arms' references.

    allowed: (N,) cells whose nearness is silent. posture: (n) rad, for which the weights of touch are computed.
    compliance_share: how far the touched places go, over what they do in other behaviours. skin: False leaves the
    reaction to touch out, for arms that are stiff. Where the robot has a sensory-motor map, the reaction is by the map.
    Where its surfaces are known, tasks above keep its bodies apart and its joints off their ends.
    """

    def make(library: TaskLibrary, chosen: ChosenGains) -> Task:
        if library.skin_map is not None:
            return library.map_reaction(chosen, compliance_share, allowed)
        gains = embrace_gains(chosen.gains, library.robot).skin_gains(library.robot, library.skin, posture)
        gains = give_share(gains, compliance_share, allowed)
        return SkinReactionTask(library.touch(gains), BANDWIDTH_HZ, own_scale=compliance_share)

    session.controller.library.add(EMBRACE_SKIN, make)
    session.controller.library.add(EMBRACE_BALANCE, _balance)
    tasks = {"joint": 0, **({EMBRACE_SKIN: 0} if skin else {}), "gravity": FEEDFORWARD}
    meaning = "takes what is before it in its arms, and gives way to touch"
    behaviour = Behaviour(EMBRACE, tasks, Fusion.weighted_sum, meaning, gains="skin_compliance")
    if session.controller.library.body is not None:
        behaviour = behaviour.protected()
    made = session.controller.use(_on_its_feet(behaviour) if session.robot.standing else behaviour)
    task = made["joint"]
    assert isinstance(task, JointTask)
    return task


def embrace_gains(gains: GainSet, robot: RobotModel) -> GainSet:
    """Gains whose trunk weighs a touch by no more than `largest_force_weight`.

    A robot that stands leans against a touch, which takes back some of what its trunk gives; so the trunk's weight may
    be larger. In an embrace the robot does not lean, and with that weight a pushed person went less far.
    """
    by_joint = gains.values["skin"].get("largest_force_weight_by_joint")
    if by_joint is None:
        return gains
    trunk = [robot.joint_index(name) for name in TRUNK]
    weights = [0.0 if joint in trunk else weight for joint, weight in enumerate(by_joint)]
    skin = gains.values["skin"] | {"largest_force_weight_by_joint": weights}
    return replace(gains, values=gains.values | {"skin": skin})


def _balance(library: TaskLibrary, _chosen: ChosenGains) -> Task:
    return BalanceTask(library.robot, embrace_balance_gains(library.balance_gains))


def embrace_balance_gains(usual: BalanceGains) -> BalanceGains:
    """A copy of these gains, which does not lean by what the skin feels.

    What both arms and the chest press is held between them, and moves no centre of mass: leaning by it would rock. It
    is a copy, since other behaviours of the same robot lean as before.
    """
    gains = BalanceGains()
    for name in (one for one in dir(BalanceGains) if not one.startswith("_")):
        setattr(gains, name, getattr(usual, name))
    gains.by_skin, gains.lean = False, LEAN
    return gains


def _on_its_feet(behaviour: Behaviour) -> Behaviour:
    """The same on a robot that stands, with the balance of an embrace."""
    standing = behaviour.standing()
    return replace(
        standing,
        tasks={(EMBRACE_BALANCE if task == "balance" else task): level for task, level in standing.tasks.items()},
    )
