# SPDX-License-Identifier: Apache-2.0
"""Gains of robots: one documented file a robot, the reader and writer of such files, and gains made from a model."""

from robotskin.robots.gains.choosing import RobotWithGains, gains_of, robot_with_gains
from robotskin.robots.gains.gain_file import GainError
from robotskin.robots.gains.gain_set import ChosenGains, GainSet, robots_with_gains
from robotskin.robots.gains.made import MadeGains, made_gains
from robotskin.robots.gains.touch_share import give_share

__all__ = [
    "ChosenGains",
    "GainError",
    "GainSet",
    "MadeGains",
    "RobotWithGains",
    "gains_of",
    "give_share",
    "made_gains",
    "robot_with_gains",
    "robots_with_gains",
]
