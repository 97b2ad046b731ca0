# SPDX-License-Identifier: Apache-2.0
"""The behaviour of the application: light fingers, and what carries them stiffly, on moving references."""

from __future__ import annotations

import numpy as np

from robotskin.apps.grasp.carriage import Carrier, OnArm, OnCarriage, grasp_place
from robotskin.apps.grasp.fingers import LIFT, PALM, THUMB, Hand
from robotskin.control import Behaviour, Fusion, Task, TaskLibrary
from robotskin.robots.gains import ChosenGains
from robotskin.session import Session
from robotskin.tasks import CartesianGains, CartesianTask, JointGains, JointImpedanceTask

GRASP, CARRY = "grasp", "carry"
FINGER_NM_RAD, FINGER_NM_S_RAD = 3.0, 0.2
"""Soft: 80 mm from a joint this is 470 N/m, a sixteenth of the skin's. With the joint's own 0.1 Nm s/rad the damping
keeps a rotor of 0.01 kg m² from swinging on that spring."""
THUMB_NM_RAD, THUMB_NM_S_RAD = 8.0, 0.4
"""Of the thumb's first joint. It works 0.08 rad from its end, with a lever of 130 mm: a push of 5 N on the thumb's back
would bring it there."""
LIFT_N_M, LIFT_N_S_M = 12000.0, 250.0
ARM_N_M, ARM_N_S_M, ARM_NM_RAD, ARM_NM_S_RAD = 12000.0, 800.0, 600.0, 30.0
"""Of an arm's hand, along and about each axis: as stiff as the carriage, damped for the 10 kg that an arm is there."""


def grasp_gains(hand: Hand, joints: int) -> JointGains:
    """Of a robot with so many joints, in its own order. An arm's joints are left to its Cartesian task."""
    stiffness, damping = np.full(joints, FINGER_NM_RAD), np.full(joints, FINGER_NM_S_RAD)
    turns = hand.joints[THUMB, 0]
    stiffness[turns], damping[turns] = THUMB_NM_RAD, THUMB_NM_S_RAD
    on_carriage = LIFT in hand.robot.joint_names
    stiffness[hand.carrier], damping[hand.carrier] = (LIFT_N_M, LIFT_N_S_M) if on_carriage else (0.0, 0.0)
    return JointGains(stiffness.tolist(), damping.tolist())


def use_grasp(session: Session, hand: Hand) -> tuple[JointImpedanceTask, Carrier]:
    """Let the session's hand follow references; returns the task that takes the joints', and what carries the hand."""
    gains = grasp_gains(hand, session.robot.joint_count)
    carried = CartesianGains([ARM_N_M] * 3 + [ARM_NM_RAD] * 3, [ARM_N_S_M] * 3 + [ARM_NM_S_RAD] * 3)

    def make(library: TaskLibrary, _gains: ChosenGains) -> Task:
        return JointImpedanceTask(library.robot, gains)

    def make_carry(library: TaskLibrary, _gains: ChosenGains) -> Task:
        return CartesianTask(library.robot, PALM, carried, CARRY)

    session.controller.library.add(GRASP, make)
    session.controller.library.add(CARRY, make_carry)
    on_carriage = LIFT in session.robot.joint_names
    levels = {GRASP: 0} if on_carriage else {GRASP: 0, CARRY: 0}
    meaning = "its fingers follow paths lightly, and what carries them does so stiffly"
    tasks = session.controller.use(Behaviour(GRASP, levels, Fusion.weighted_sum, meaning, gains="skin_compliance"))
    task = tasks[GRASP]
    assert isinstance(task, JointImpedanceTask)
    if on_carriage:
        return task, OnCarriage()
    carry = tasks[CARRY]
    assert isinstance(carry, CartesianTask)
    resting = np.array(session.joints.position)[hand.carrier]
    return task, OnArm(carry, grasp_place(session.robot, session.home), resting, ARM_N_S_M / ARM_N_M)
