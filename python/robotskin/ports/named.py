# SPDX-License-Identifier: Apache-2.0
"""Robot ports by name: `ur:ADDRESS`, `franka:ADDRESS`, `ros2:DOMAIN…` of ros2_control, `MODULE:CLASS` of your own."""

from __future__ import annotations

import importlib
import inspect
import os
import sys
from collections.abc import Callable

from robotskin.errors import RobotskinError
from robotskin.franka import FrankaPort
from robotskin.model import RobotPort
from robotskin.robots import Robot
from robotskin.ros2 import Ros2Error
from robotskin.ros2.joints_name import joints_name
from robotskin.ur import UrPort

BUILT_IN = ("ur", "franka", "ros2")
CHOICES = "give ur:ADDRESS, franka:ADDRESS, ros2:DOMAIN, or MODULE:CLASS of your own"
REALTIME = ",realtime"


class PortError(RobotskinError):
    """A port that cannot be had; the message names it, what was found and what was expected."""


def made_port(name: str, robot: Robot | None = None) -> RobotPort:
    """The port of that name, ready to be read.

    Args:
        name: "ur:ADDRESS", "franka:ADDRESS[,realtime]", "ros2:DOMAIN[,KEY[=VALUE]]…" (`robotskin.ros2.joints_name`), or
            "MODULE:CLASS" (or "MODULE" where it holds one class of ports) of a class that is made without arguments;
            modules are looked for in the folder in which one works, too.
        robot: what it is to move; a UR's gravity comes from it, and its name says which robot must answer.

    Raises:
        PortError: no such module or class, a class that cannot be made, another count of joints than the robot's.
        UrError: what stands against a UR at that address; FrankaError, Ros2Error: the same for these.
    """
    kind, _, rest = name.partition(":")
    if kind in BUILT_IN:
        if not rest.split(",")[0]:
            raise PortError(f"port {name!r}: its address is missing; {CHOICES}")
        if robot is None:
            raise PortError(f"port {name}: which robot is it? Give --robot, such as --robot ur5")
        if kind == "ur":
            if rest.count(":") == 1:
                raise PortError(
                    f"port {name}: give the address alone, ur:{rest.partition(':')[0]}; its ports are known"
                )
            return UrPort(robot.core, rest, expected=_ur_model(robot), realtime=True)
        return _ros2(name, robot) if kind == "ros2" else _franka(rest, robot)
    port = _own(name, kind, rest)
    if robot is not None and port.joint_count != robot.joint_count:
        raise PortError(f"port {name}: found {port.joint_count} joints, {robot.name} has {robot.joint_count}")
    return port


def _ros2(name: str, robot: Robot) -> RobotPort:
    named = joints_name(name, robot.joint_names)
    try:
        from robotskin.ros2.joints_port import Ros2Port
    except ImportError as error:
        raise Ros2Error(f"port {name}: {error.name} is not installed: pip install 'robotskin[ros2]'") from error
    return Ros2Port(robot, named)


def _franka(rest: str, robot: Robot) -> RobotPort:
    return FrankaPort(robot, rest.removesuffix(REALTIME), realtime=rest.endswith(REALTIME))


def _ur_model(robot: Robot) -> str:
    """What the dashboard of this robot must say: UR5 for ur5 and ur5_robot; empty for a robot of another name."""
    letters = robot.name.lower()
    digits = "".join(letter for letter in letters[2:4] if letter.isdigit())
    return f"UR{digits}" if letters.startswith("ur") and digits else ""


def _own(name: str, module: str, wanted: str) -> RobotPort:
    if os.getcwd() not in sys.path:
        sys.path.insert(0, os.getcwd())
    try:
        found = importlib.import_module(module)
    except Exception as error:
        raise PortError(f"port {name!r}: {type(error).__name__}: {error}; {CHOICES}") from error
    classes: dict[str, Callable[[], RobotPort]] = {
        key: one
        for key, one in vars(found).items()
        if inspect.isclass(one) and issubclass(one, RobotPort) and one.__module__ == found.__name__
    }
    if wanted and wanted not in classes:
        raise PortError(f"port {name}: {module} has no port {wanted}; its ports: {', '.join(classes) or 'none'}")
    if not wanted and len(classes) != 1:
        raise PortError(f"port {name}: name one, {module}:CLASS; its ports: {', '.join(classes) or 'none'}")
    chosen = classes[wanted or next(iter(classes))]
    try:
        return chosen()
    except Exception as error:
        raise PortError(f"port {name}: cannot be made: {type(error).__name__}: {error}") from None
