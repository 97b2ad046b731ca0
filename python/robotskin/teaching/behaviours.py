# SPDX-License-Identifier: Apache-2.0
"""The two behaviours of a robot that is taught: work with its gripper, and be led by its skin."""

from __future__ import annotations

from robotskin.control import FEEDFORWARD, Behaviour, Fusion
from robotskin.session import SkinnedRobot
from robotskin.tasks import JointTask

WORK = Behaviour(
    "work_with_gripper",
    {"joint": 0, "skin": 0, "gravity": FEEDFORWARD},
    Fusion.weighted_sum,
    "works with its gripper and gives way to touch",
    gains="skin_compliance",
)
LED = Behaviour(
    "led_by_skin",
    {"joint": 0, "gravity": FEEDFORWARD},
    Fusion.weighted_sum,
    "goes where its skin is pushed, its gripper looking down",
    gains="skin_compliance",
)


def use(session: SkinnedRobot, behaviour: Behaviour) -> JointTask:
    """Let a session's robot do this; returns the task that takes references."""
    task = session.controller.use(behaviour)["joint"]
    assert isinstance(task, JointTask)
    return task
