# SPDX-License-Identifier: Apache-2.0
"""Joints as people read them, and sliders that bend the robot of a page that has no session."""

from collections.abc import Callable

import numpy as np
import viser

from robotskin.viewer.session_view import Floats, RobotView


def joint_name(name: str) -> str:
    """A joint's name without what all of them have."""
    return name.removesuffix("_joint").replace("_", " ")


def shown_unit(slides: bool) -> tuple[str, float]:
    """The unit in which a joint is shown, and how many of them a metre or a radian has."""
    return ("mm", 1e3) if slides else ("°", 180 / np.pi)


def shown_limits(robot: RobotView, joint: int) -> tuple[float, float]:
    """Rad or m between which a slider goes: the joint's limits, a turn or a metre to each side at most."""
    most = 1.0 if robot.joint_slides[joint] else 2 * np.pi
    return float(np.maximum(robot.lower[joint], -most)), float(np.minimum(robot.upper[joint], most))


def joint_sliders(
    server: viser.ViserServer, robot: RobotView, posture: Floats, bend: Callable[[int, float], None]
) -> None:
    """One slider a joint, from `posture` (n,), within its limits; `bend` gets the joint and rad or m."""
    for joint in range(len(robot.joint_names)):
        _joint_slider(server, robot, joint, float(posture[joint]), bend)


def _joint_slider(
    server: viser.ViserServer, robot: RobotView, joint: int, value: float, bend: Callable[[int, float], None]
) -> None:
    unit, factor = shown_unit(robot.joint_slides[joint])
    low, high = (round(limit * factor, 1) for limit in shown_limits(robot, joint))
    name = f"{joint_name(robot.joint_names[joint])} [{unit}]"
    slider = server.gui.add_slider(name, low, high, 0.1, float(np.clip(round(value * factor, 1), low, high)))

    @slider.on_update
    def _(_: viser.GuiEvent) -> None:
        limit = (float(robot.lower[joint]), float(robot.upper[joint]))
        bend(joint, float(np.clip(slider.value / factor, *limit)))
