# SPDX-License-Identifier: Apache-2.0
"""The ends of a robot's joints give way a little, and less than what the guard bears."""

import mujoco
import numpy as np

from robotskin import robots
from robotskin.cycle import GuardLimits
from robotskin.layout import finished
from robotskin.world import scene

ROBOT = "allegro_right_hand"
LIGHT_NM = 0.3
"""What 10 N on a finger's outer link come to."""


def test_a_finger_thrown_onto_the_end_of_a_joint_stays_within_the_guards_tolerance(generator) -> None:
    robot = robots.load(ROBOT)
    joint = int(generator.integers(robot.core.joint_count))
    upwards = bool(generator.integers(2))
    posture = 0.5 * (robot.core.lower + robot.core.upper)
    end = (robot.core.upper if upwards else robot.core.lower)[joint]
    posture[joint] = 0.9 * end + 0.1 * posture[joint]
    built = scene.build(robot, finished(ROBOT), posture)
    model, data = built.model, built.data
    model.opt.gravity[:] = 0
    dof, place = model.jnt_dofadr[built.robot_joints[joint]], model.jnt_qposadr[built.robot_joints[joint]]
    beyond = []
    for _ in range(600):
        data.qfrc_applied[dof] = LIGHT_NM if upwards else -LIGHT_NM
        mujoco.mj_step(model, data)
        beyond.append((data.qpos[place] - end) * (1 if upwards else -1))
    tolerance = GuardLimits([1.0], [1.0], [1.0]).end_tolerance
    assert max(beyond) > -1e-3, "it never came to the end"
    assert max(beyond) < tolerance, (robot.core.joint_names[joint], np.max(beyond))
