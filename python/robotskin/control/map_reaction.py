# SPDX-License-Identifier: Apache-2.0
"""The reaction to touch by a learnt sensory-motor map: its weights are chosen as those of the model's reaction are."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from robotskin.model import RobotModel
from robotskin.robots.gains import ChosenGains, give_share
from robotskin.selfconfig.map.sensory_motor_map import SensoryMotorMap
from robotskin.skin import SkinModel
from robotskin.tasks import MapSkinTask

MAP_LEVER_M = 0.3
"""Without a model it is not known how long a cell's lever is; of an arm it is about this."""


def map_skin_task(
    robot: RobotModel,
    skin: SkinModel,
    found: SensoryMotorMap,
    chosen: ChosenGains,
    compliance_share: float = 1.0,
    silent: NDArray[np.bool_] | None = None,
) -> MapSkinTask:
    """The task, whose weights let a newton move a cell by the same length as the model's reaction does.

    Of that only the map is used: where its weights turn the joints the most, they turn them by that length over the
    lever.

    Args:
        robot: n joints.
        skin: N cells; those that the map does not know ask for nothing.
        found: the map, of the robot's joints.
        chosen: gains of the behaviour.
        compliance_share: how far touched places go, over what the gains state.
        silent: (N,) cells whose nearness is silent; by default none.
    """
    row = {int(key): index for index, key in enumerate(found.cell)}
    known = np.array([int(key) in row for key in skin.key])
    weight = np.zeros((len(found.posture), len(skin), robot.joint_count))
    weight[:, known] = found.weight[:, [row[int(key)] for key in skin.key[known]]]

    values = chosen.gains.values
    turn = MAP_LEVER_M * np.abs(weight) / np.array(values["joint"]["stiffness"])
    turn_of_cell = turn.max(axis=(0, 2))  # (N) rad/N
    wanted = values["skin"]["compliance_m_per_n"] / MAP_LEVER_M
    with np.errstate(divide="ignore"):
        total = np.minimum(wanted, values["skin"]["largest_give_rad_per_n"]) / turn_of_cell
    force = np.where(turn_of_cell > 0, np.clip(total - 1, 0, values["skin"]["largest_force_weight"]), 0.0)
    gains = give_share(chosen.skin_weighted(force), compliance_share, silent)
    return MapSkinTask(robot.joint_count, len(skin), gains, found.posture, weight, MAP_LEVER_M)
