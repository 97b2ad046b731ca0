# SPDX-License-Identifier: Apache-2.0
"""Behaviours of skinned robots: tasks from the core's library, put together by name, and changed while they run."""

from robotskin.control.behaviour import BEHAVIOURS, Behaviour, behaviour
from robotskin.control.controller import Controller
from robotskin.control.primitive import CartesianGoal, ForceGoal, Goal, JointGoal, Primitive, primitive
from robotskin.control.task_library import TASKS, TaskLibrary
from robotskin.tasks import FEEDFORWARD, Fusion, PythonTask

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
    "Primitive",
    "PythonTask",
    "TaskLibrary",
    "behaviour",
    "primitive",
]
