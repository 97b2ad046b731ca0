# SPDX-License-Identifier: Apache-2.0
"""Robot and skin that are not there, behind real sockets: what a first start on hardware is rehearsed with.

In: a robot and a layout. Out: a UR controller (RTDE, dashboard, script ports) or a Franka on MuJoCo, and section units
on UDP or pseudo-terminals whose cells follow the joints of whatever controller they are told of. Each runs in a
process of its own.
"""

from robotskin.rehearsal.asked import Asked, Look
from robotskin.rehearsal.franka_process import franka_controller
from robotskin.rehearsal.process import Process, RehearsalError
from robotskin.rehearsal.serial_skin import SerialSkin, host_cells
from robotskin.rehearsal.skin_process import serial_skin, skin
from robotskin.rehearsal.ur_controller import ControllerSettings, FakeController
from robotskin.rehearsal.ur_process import controller

__all__ = [
    "Asked",
    "ControllerSettings",
    "FakeController",
    "Look",
    "Process",
    "RehearsalError",
    "SerialSkin",
    "controller",
    "franka_controller",
    "host_cells",
    "serial_skin",
    "skin",
]
