# SPDX-License-Identifier: Apache-2.0
"""Sliders that bend the robot of a page that has no session."""

from collections.abc import Callable

import numpy as np
import viser

from robotskin.robots import Robot
from robotskin.viewer.session_view import Floats


def joint_sliders(server: viser.ViserServer, robot: Robot, posture: Floats, bend: Callable[[int, float], None]) -> None:
    """One slider a joint, from `posture` (n,), within its limits and a turn; `bend` gets the joint and rad or m."""
    for joint in range(robot.joint_count):
        _joint_slider(server, robot, joint, float(posture[joint]), bend)


def _joint_slider(
    server: viser.ViserServer, robot: Robot, joint: int, value: float, bend: Callable[[int, float], None]
) -> None:
    lower = float(np.maximum(robot.lower[joint], -np.pi))
    upper = float(np.minimum(robot.upper[joint], np.pi))
    name = robot.joint_names[joint].removesuffix("_joint").replace("_", " ")
    slider = server.gui.add_slider(name, lower, upper, 0.01, value)

    @slider.on_update
    def _(_: viser.GuiEvent) -> None:
        bend(joint, slider.value)
