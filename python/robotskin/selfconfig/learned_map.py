# SPDX-License-Identifier: Apache-2.0
"""The sensory-motor map of a skin that found out where its cells are."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from robotskin.robots import Robot
from robotskin.selfconfig.configuration import Configuration
from robotskin.selfconfig.map.sensory_motor_map import SensoryMotorMap, SignRule, build_map
from robotskin.selfconfig.readings.expected_motion import gravity_while_swinging
from robotskin.selfconfig.readings.motion_recording import MotionRecording
from robotskin.selfconfig.readings.recording import BabblingRecording
from robotskin.selfconfig.recorded import rows_of, swings_in

Array = NDArray[np.float64]


def learn_map(
    robot: Robot,
    recording: BabblingRecording,
    configuration: Configuration,
    sign: SignRule = "correlation",
    suppression: float = 0.1,
    normalise: bool = True,
) -> SensoryMotorMap:
    """The sensory-motor map of all cells; gravity is removed from those whose orientation is known.

    With the sign rule "motion" nothing but topology and activity is needed of the configuration: the skin learns the
    map without a kinematic model and without knowing where its cells are.

    Args:
        robot: kinematic model; with the sign rule "motion" only its names are used.
        recording: of the babbling.
        configuration: made from it.
        sign: rule of `sensory_motor_map.weights`; suppression, normalise: of `build_map`.
        suppression: see sign.
        normalise: see sign.
    """
    order = rows_of(recording, configuration.topology)
    count = len(order)
    link, pose, known = np.zeros(count, dtype=np.int64), np.tile(np.eye(4), (count, 1, 1)), configuration.placed()
    for patch in configuration.patches:
        if patch.placed and patch.localisation is not None:
            pose[patch.cells] = patch.link_from_cell()
            link[patch.cells] = robot.link_index(patch.localisation.link)
    swings = swings_in(recording, order)

    def gravity_in(swing: MotionRecording) -> Array:
        felt = np.zeros((count, len(swing.time_s), 3))
        # The weights of the others are masked.
        told = known & configuration.activity[swing.swing.joint]
        felt[told] = gravity_while_swinging(robot, link[told], pose[told], swing.swing, swing.time_s)
        return felt

    return build_map(
        robot.name,
        robot.joint_names,
        configuration.topology.cell,
        swings,
        configuration.activity,
        None if sign == "motion" else gravity_in,
        sign=sign,
        suppression=suppression,
        normalise=normalise,
    )
