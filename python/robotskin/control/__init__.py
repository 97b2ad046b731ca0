# SPDX-License-Identifier: Apache-2.0
"""Behaviours of skinned robots: tasks from the core's library, put together by name, and changed while they run."""

from robotskin.control.behaviour import BEHAVIOURS, Behaviour, behaviour
from robotskin.control.controller import Controller
from robotskin.control.primitive import CartesianGoal, ForceGoal, Goal, JointGoal, Primitive, primitive
from robotskin.control.task_library import TASKS, TaskLibrary, propagated_compliance
from robotskin.robots.limbs import limbs_of
from robotskin.tasks import FEEDFORWARD, Fusion, Limb, PropagationGains, PythonTask, Task

__all__ = [
    "BEHAVIOURS",
    "FEEDFORWARD",
    "TASKS",
    "Behaviour",
    "CartesianGoal",
    "Controller",
    "ForceGoal",
    "Fusion",
    "Goal",
    "JointGoal",
    "Limb",
    "Primitive",
    "PropagationGains",
    "PythonTask",
    "Task",
    "TaskLibrary",
    "behaviour",
    "limbs_of",
    "primitive",
    "propagated_compliance",
]
