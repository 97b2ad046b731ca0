# SPDX-License-Identifier: Apache-2.0
"""The behaviour of an embrace: its arms follow references and give way to touch; nearness is silent where it hugs."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from robotskin.control import FEEDFORWARD, Behaviour, TaskLibrary
from robotskin.robots.gains import ChosenGains, give_share
from robotskin.session import SkinnedRobot
from robotskin.tasks import Fusion, JointTask, SkinReactionTask, Task

EMBRACE, EMBRACE_SKIN = "embrace", "embrace_skin"
BANDWIDTH_HZ = 5.0
LEAN = 0.0
"""Of the reaction to touch. Arms that press a heavy body from two sides swing with it if they answer faster."""


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
    """

    def make(library: TaskLibrary, chosen: ChosenGains) -> Task:
        if library.skin_map is not None:
            return library.map_reaction(chosen, compliance_share, allowed)
        gains = give_share(chosen.gains.skin_gains(library.robot, library.skin, posture), compliance_share, allowed)
        return SkinReactionTask(library.touch(gains), BANDWIDTH_HZ, own_scale=compliance_share)

    session.controller.library.add(EMBRACE_SKIN, make)
    # What both arms and the chest press is held between them, and moves no centre of mass: leaning by it would rock.
    balance = session.controller.library.balance_gains
    balance.by_skin, balance.lean = False, LEAN
    tasks = {"joint": 0, **({EMBRACE_SKIN: 0} if skin else {}), "gravity": FEEDFORWARD}
    meaning = "takes what is before it in its arms, and gives way to touch"
    behaviour = Behaviour(EMBRACE, tasks, Fusion.weighted_sum, meaning, gains="skin_compliance")
    made = session.controller.use(behaviour.standing() if session.robot.standing else behaviour)
    task = made["joint"]
    assert isinstance(task, JointTask)
    return task
