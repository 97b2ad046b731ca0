# SPDX-License-Identifier: Apache-2.0
"""The names of `import robotskin as rs`, and where each is at home: the one list, which `__init__.py` reads."""

from robotskin.configuring.configured import configured
from robotskin.control import (
    BEHAVIOURS,
    Behaviour,
    CartesianGoal,
    ForceGoal,
    JointGoal,
    LimbGoals,
    TaskLibrary,
    behaviour,
)
from robotskin.cycle import SafetyState, SkinSource
from robotskin.driver import Driver
from robotskin.errors import RobotskinError
from robotskin.keys import SkinKeys
from robotskin.layout import Layout, cover
from robotskin.layout import finished as finished_layout
from robotskin.layout import finished_names as layout_names
from robotskin.layout import read as read_layout
from robotskin.model import CommandMode, JointCommand, JointState, PortStatus, RobotDynamics, RobotPort
from robotskin.record import Recording, recorded
from robotskin.robots import Robot, robot_names
from robotskin.robots import load as load_robot
from robotskin.robots.gains import GainSet, gains_of
from robotskin.session import Session, SkinnedRobot
from robotskin.session.goals import hand_pose
from robotskin.session.touches import push_and_release, pushed_cell
from robotskin.skin import Health, InputStatus, SkinInput, SkinModel, SkinState
from robotskin.tasks import FEEDFORWARD, Fusion, PythonTask
from robotskin.world import Imperfections, World, load_scene, scene_names

__version__: str

__all__ = [
    "BEHAVIOURS",
    "FEEDFORWARD",
    "Behaviour",
    "CartesianGoal",
    "CommandMode",
    "Driver",
    "ForceGoal",
    "Fusion",
    "GainSet",
    "Health",
    "Imperfections",
    "InputStatus",
    "JointCommand",
    "JointGoal",
    "JointState",
    "Layout",
    "LimbGoals",
    "PortStatus",
    "PythonTask",
    "Recording",
    "Robot",
    "RobotDynamics",
    "RobotPort",
    "RobotskinError",
    "SafetyState",
    "Session",
    "SkinInput",
    "SkinKeys",
    "SkinModel",
    "SkinSource",
    "SkinState",
    "SkinnedRobot",
    "TaskLibrary",
    "World",
    "behaviour",
    "configured",
    "cover",
    "finished_layout",
    "gains_of",
    "hand_pose",
    "layout_names",
    "load_robot",
    "load_scene",
    "push_and_release",
    "pushed_cell",
    "read_layout",
    "recorded",
    "robot_names",
    "scene_names",
]
