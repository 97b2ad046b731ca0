# SPDX-License-Identifier: Apache-2.0
"""A UR controller in a process of its own."""

from __future__ import annotations

from collections.abc import Sequence

from robotskin import robots
from robotskin.rehearsal.process import Process
from robotskin.rehearsal.ur_controller import ControllerSettings, FakeController
from robotskin.robots.gains import gains_of


def make(
    robot: str, host: str, settings: ControllerSettings, posture: Sequence[float] | None, friction: float | None
) -> FakeController:
    """In the process that shall run it."""
    model = robots.load(robot)
    return FakeController(model, gains_of(model).home if posture is None else posture, host, settings, friction)


def controller(
    robot: str = "ur5",
    host: str = "127.0.0.1",
    settings: ControllerSettings | None = None,
    posture: Sequence[float] | None = None,
    friction: float | None = None,
) -> Process:
    """Start a controller at an address of this machine. Raises RehearsalError if it cannot be had.

    Args:
        robot: by name or URDF, 6 joints.
        host: of this machine, such as 127.0.0.2: each controller needs one of its own.
        settings: model, software version, remote control.
        posture: (6,) rad where it starts; by default the home of the robot's gains.
        friction: of the joints; see `UrArm`.
    """
    return Process(
        make, robot=robot, host=host, settings=settings or ControllerSettings(), posture=posture, friction=friction
    )
