# SPDX-License-Identifier: Apache-2.0
"""Behaviours of skinned robots: tasks from the core's library, put together by name, and changed while they run."""

from robotskin.control.behaviour import BEHAVIOURS, Behaviour, Part, behaviour
from robotskin.control.controller import Controller
from robotskin.control.goal import CartesianGoal, ForceGoal, Goal, JointGoal, LimbGoals
from robotskin.control.limb_primitive import limb_primitive
from robotskin.control.primitive import Primitive, primitive
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
    "LimbGoals",
    "Part",
    "Primitive",
    "PropagationGains",
    "PythonTask",
    "Task",
    "TaskLibrary",
    "behaviour",
    "limb_primitive",
    "limbs_of",
    "primitive",
    "propagated_compliance",
]
