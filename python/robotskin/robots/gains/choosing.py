# SPDX-License-Identifier: Apache-2.0
"""A robot together with gains that fit it: from a file, from the project, or made on the spot."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

from robotskin.errors import InputError
from robotskin.robots.gains.gain_set import GainSet, robots_with_gains
from robotskin.robots.gains.made import made_gains
from robotskin.robots.loading import load
from robotskin.robots.locking import joints_to_lock
from robotskin.robots.robot import Robot


@dataclass(frozen=True, eq=False)
class RobotWithGains:
    """A robot, its joints locked as its gains say. source: where the gains come from, in words; made: on the spot."""

    robot: Robot
    gains: GainSet
    source: str
    made: bool


def robot_with_gains(name_or_path: str, gains_file: Path | None = None) -> RobotWithGains:
    """Load a robot and the gains to run it with.

    Args:
        name_or_path: as `robots.load` takes it.
        gains_file: to use; by default those that come with the project, else gains are made (`made_gains`), with the
            joints of `joints_to_lock` locked.

    Raises:
        InputError: a gains file whose name does not end in .toml. GainError: gains that do not fit or cannot be made.
        What `robots.load` raises.
    """
    if gains_file is not None:
        if gains_file.suffix != ".toml":
            raise InputError(f"--gains {gains_file}: the name of a gain file ends in .toml")
        gains = GainSet.load(str(gains_file))
        return _fitting(load(name_or_path, locked=gains.locked), gains, str(gains_file))
    robot = load(name_or_path)
    if robot.name in robots_with_gains():
        gains = GainSet.load(robot.name)
        return _fitting(load(name_or_path, locked=gains.locked) if gains.locked else robot, gains, "the project")
    locked = joints_to_lock(robot)
    robot = load(name_or_path, locked=locked) if locked else robot
    return RobotWithGains(robot, made_gains(robot).gains, "its inertia and limits", True)


def gains_of(robot: Robot) -> GainSet:
    """The gains that come with the project for a robot that is loaded already, else gains made for it as it is."""
    if robot.name in robots_with_gains():
        gains = GainSet.load(robot.name)
        if len(gains.home) == robot.joint_count:
            return gains
    return made_gains(robot).gains


def _fitting(robot: Robot, gains: GainSet, source: str) -> RobotWithGains:
    gains.require_fit(robot.core)
    return RobotWithGains(robot, gains, source, False)
