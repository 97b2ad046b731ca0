# SPDX-License-Identifier: Apache-2.0
"""A skinned robot in one object: between two ends of any kind, or those of a simulated world.

A robot of your own derives from `RobotPort`, a skin of your own from `SkinInput`; `SkinnedRobot` runs between them.
"""

from robotskin.choices import INTERFACES, MODES, SOURCES
from robotskin.cycle import SafetyState
from robotskin.firmware import CellMode
from robotskin.loop import LoopError, LoopReport, SkinLoop
from robotskin.model import (
    CommandMode,
    PortSensors,
    PortStatus,
    RobotPort,
    SensorPlace,
)
from robotskin.session.lost_cells import LostCells
from robotskin.session.session import Session
from robotskin.session.skinned_robot import PERIOD_S, SessionError, SkinnedRobot
from robotskin.skin import Health, InputStatus, SkinInput

__all__ = [
    "INTERFACES",
    "MODES",
    "PERIOD_S",
    "SOURCES",
    "CellMode",
    "CommandMode",
    "Health",
    "InputStatus",
    "LoopError",
    "LoopReport",
    "LostCells",
    "PortSensors",
    "PortStatus",
    "RobotPort",
    "SafetyState",
    "SensorPlace",
    "Session",
    "SessionError",
    "SkinInput",
    "SkinLoop",
    "SkinnedRobot",
]
