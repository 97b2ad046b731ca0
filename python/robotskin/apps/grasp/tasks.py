# SPDX-License-Identifier: Apache-2.0
"""The behaviour of the application: light fingers and a stiff carriage on moving references."""

from __future__ import annotations

import numpy as np

from robotskin.apps.grasp.fingers import THUMB, Hand
from robotskin.control import Behaviour, Fusion, Task, TaskLibrary
from robotskin.robots.gains import ChosenGains
from robotskin.session import Session
from robotskin.tasks import JointGains, JointImpedanceTask

GRASP = "grasp"
FINGER_NM_RAD, FINGER_NM_S_RAD = 3.0, 0.2
"""Soft: 80 mm from a joint this is 470 N/m, a sixteenth of the skin's. With the joint's own 0.1 Nm s/rad the damping
keeps a rotor of 0.01 kg m² from swinging on that spring."""
THUMB_NM_RAD, THUMB_NM_S_RAD = 8.0, 0.4
"""Of the thumb's first joint. It works 0.08 rad from its end, with a lever of 130 mm: a push of 5 N on the thumb's back
would bring it there."""
LIFT_N_M, LIFT_N_S_M = 12000.0, 250.0


def grasp_gains(hand: Hand, joints: int) -> JointGains:
    """Of a robot with so many joints, in its own order."""
    stiffness, damping = np.full(joints, FINGER_NM_RAD), np.full(joints, FINGER_NM_S_RAD)
    turns = hand.joints[THUMB, 0]
    stiffness[turns], damping[turns] = THUMB_NM_RAD, THUMB_NM_S_RAD
    stiffness[hand.lift], damping[hand.lift] = LIFT_N_M, LIFT_N_S_M
    return JointGains(stiffness.tolist(), damping.tolist())


def use_grasp(session: Session, hand: Hand) -> JointImpedanceTask:
    """Let the session's hand follow references; returns the task that takes them."""
    gains = grasp_gains(hand, session.robot.joint_count)

    def make(library: TaskLibrary, _gains: ChosenGains) -> Task:
        return JointImpedanceTask(library.robot, gains)

    session.controller.library.add(GRASP, make)
    meaning = "its fingers follow paths lightly, and its carriage stiffly"
    tasks = session.controller.use(Behaviour(GRASP, {GRASP: 0}, Fusion.weighted_sum, meaning, gains="skin_compliance"))
    task = tasks[GRASP]
    assert isinstance(task, JointImpedanceTask)
    return task
