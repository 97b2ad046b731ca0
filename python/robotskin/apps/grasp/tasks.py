# SPDX-License-Identifier: Apache-2.0
"""The behaviour of the application: light fingers and a stiff carriage on moving references."""

from __future__ import annotations

import numpy as np

from robotskin.apps.grasp.fingers import Hand
from robotskin.control import Behaviour, Fusion, Task, TaskLibrary
from robotskin.robots.gains import ChosenGains
from robotskin.session import Session
from robotskin.tasks import JointGains, JointImpedanceTask

GRASP = "grasp"
FINGER_NM_RAD, FINGER_NM_S_RAD = 3.0, 0.02
"""Soft: 80 mm from a joint this is 470 N/m, a sixteenth of the skin's."""
LIFT_N_M, LIFT_N_S_M = 12000.0, 250.0


def use_grasp(session: Session, hand: Hand) -> JointImpedanceTask:
    """Let the session's hand follow references; returns the task that takes them."""
    joints = session.robot.joint_count
    stiffness, damping = np.full(joints, FINGER_NM_RAD), np.full(joints, FINGER_NM_S_RAD)
    stiffness[hand.lift], damping[hand.lift] = LIFT_N_M, LIFT_N_S_M
    gains = JointGains(stiffness.tolist(), damping.tolist())

    def make(library: TaskLibrary, _gains: ChosenGains) -> Task:
        return JointImpedanceTask(library.robot, gains)

    session.controller.library.add(GRASP, make)
    meaning = "its fingers follow paths lightly, and its carriage stiffly"
    tasks = session.controller.use(Behaviour(GRASP, {GRASP: 0}, Fusion.weighted_sum, meaning, gains="skin_compliance"))
    task = tasks[GRASP]
    assert isinstance(task, JointImpedanceTask)
    return task
