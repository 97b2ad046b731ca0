"""Makes tasks by name, with the gains that the robot's file states for a behaviour."""

from __future__ import annotations

from collections.abc import Callable

from robotskin._core.control import (
    CartesianTask,
    ContactImpedanceTask,
    GravityTask,
    JointLimitTask,
    JointTask,
    SkinCartesianTask,
    SkinReactionTask,
    SplineCartesianTask,
    SplineJointTask,
    Task,
)
from robotskin._core.model import RobotModel
from robotskin._core.skin import SkinModel
from robotskin.errors import UnknownNameError
from robotskin.robots.gains import ChosenGains

Maker = Callable[["TaskLibrary", ChosenGains], Task]


class TaskLibrary:
    """Tasks for one robot and its skin. What a user adds under a name of their own can be part of a behaviour.

    Args:
        robot: n joints.
        skin: N cells.
    """

    def __init__(self, robot: RobotModel, skin: SkinModel) -> None:
        self.robot, self.skin = robot, skin
        self._makers: dict[str, Maker] = dict(_MAKERS)

    @property
    def names(self) -> tuple[str, ...]:
        """Of all tasks that can be made."""
        return tuple(self._makers)

    def add(self, name: str, make: Maker) -> None:
        """Add a task: `make(library, gains)` returns it, a task of the core's or a `PythonTask`."""
        self._makers[name] = make

    def make(self, name: str, gains: ChosenGains) -> Task:
        """A new task. Raises UnknownNameError, and ModelError or ControlError for gains that do not fit the robot."""
        if name not in self._makers:
            raise UnknownNameError("task", name, self._makers)
        return self._makers[name](self, gains)


def _skin_filter_hz(gains: ChosenGains) -> float:
    return float(gains.gains.values["skin"]["bandwidth_hz"])


_MAKERS: dict[str, Maker] = {
    "gravity": lambda own, gains: GravityTask(own.robot.joint_count),
    "joint": lambda own, gains: JointTask(own.robot, gains.joint),
    "spline_joint": lambda own, gains: SplineJointTask(own.robot, gains.joint, gains.speed_rad_s),
    "cartesian": lambda own, gains: CartesianTask(own.robot, gains.link, gains.cartesian),
    "spline_cartesian": lambda own, gains: SplineCartesianTask(
        own.robot, gains.link, gains.cartesian, gains.speed_m_s, gains.turn_speed_rad_s
    ),
    "skin": lambda own, gains: SkinReactionTask(
        own.robot, own.skin, gains.skin(own.robot, own.skin), _skin_filter_hz(gains)
    ),
    "skin_cartesian": lambda own, gains: SkinCartesianTask(
        own.robot, own.skin, gains.skin(own.robot, own.skin), gains.link, _skin_filter_hz(gains)
    ),
    "contact_impedance": lambda own, gains: ContactImpedanceTask(own.robot, own.skin, gains.skin(own.robot, own.skin)),
    "joint_limits": lambda own, gains: JointLimitTask(own.robot),
    "posture": lambda own, gains: JointTask(own.robot, gains.joint, "posture"),
}

TASKS = tuple(_MAKERS)
"""Names of the library's tasks. A map skin task needs a map, a self-collision task hulls: add them where these are."""
