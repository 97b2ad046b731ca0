# SPDX-License-Identifier: Apache-2.0
"""What the simulated robot measures beside its joints; a standing one has an inertial unit and forces at its ankles."""

from __future__ import annotations

from typing import Any

import mujoco

from robotskin.model import PortSensors, SensorPlace
from robotskin.robots import Robot
from robotskin.robots.standing import BASE_JOINTS


def sensors_of(robot: Robot, model: mujoco.MjModel) -> dict[str, Any]:
    """Arguments of the core's body: the places of sensors, the bodies that carry them, how many joints are the base's.

    A foot's force and moment are measured about the origin of the foot's link, along its axes.
    """
    standing = robot.standing
    if standing is None:
        return {}
    links = [foot.link for foot in standing.feet]
    return {
        "sensors": PortSensors(
            imus=[SensorPlace("imu", standing.imu_link)], forces=[SensorPlace(f"{link}_force", link) for link in links]
        ),
        "imu_body": [model.body(standing.imu_link).id],
        "force_body": [model.body(link).id for link in links],
        "base_joints": len(BASE_JOINTS),
    }
