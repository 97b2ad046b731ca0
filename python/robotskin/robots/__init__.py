# SPDX-License-Identifier: Apache-2.0
"""Stage 0: robots by URDF or by name, as one Pinocchio and one MuJoCo model that agree.

In: the name of a robot or the path of a URDF. Out: a `Robot`. Once at start. What can go wrong: no such robot, text
that is no URDF, a mesh that is missing (typed errors), an inertia no body can have (repaired and listed).
"""

from robotskin.robots.catalog import robot_names
from robotskin.robots.errors import (
    MalformedUrdfError,
    MissingMeshError,
    ModelsDisagreeError,
    ModelsNotInstalledError,
    UnreadableMeshError,
    UrdfNotFoundError,
)
from robotskin.robots.loading import from_text, load
from robotskin.robots.repair import Mimic, Repair
from robotskin.robots.robot import Robot

__all__ = [
    "MalformedUrdfError",
    "Mimic",
    "MissingMeshError",
    "ModelsDisagreeError",
    "ModelsNotInstalledError",
    "Repair",
    "Robot",
    "UnreadableMeshError",
    "UrdfNotFoundError",
    "from_text",
    "load",
    "robot_names",
]
