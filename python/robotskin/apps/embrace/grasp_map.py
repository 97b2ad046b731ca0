# SPDX-License-Identifier: Apache-2.0
"""The skin learns how touch shall move both arms: they babble about the postures of a grasp, without a thing (IV-A)."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from robotskin.apps.embrace.arms import SIDES, Arms, Paths
from robotskin.apps.embrace.grasp_control import GRASP_AROUND, GRASP_HOLD
from robotskin.apps.embrace.grasp_script import LAYOUT, ROBOT, Progress
from robotskin.apps.embrace.regulation import OPEN_M
from robotskin.configuring.exploration import Exploration
from robotskin.layout import finished
from robotskin.robots.free_space import FreeSpace
from robotskin.robots.gains import RobotWithGains, robot_with_gains
from robotskin.selfconfig.babbling.joint_sine import MotionLimits, plan_joint_sine
from robotskin.selfconfig.babbling.plan import BabblingPlan
from robotskin.selfconfig.babbling.postures import BabblingError, PosturePlan
from robotskin.selfconfig.configure import configure
from robotskin.selfconfig.learned_map import learn_map
from robotskin.selfconfig.map.sensory_motor_map import SensoryMotorMap

Array = NDArray[np.float64]

HELD_M, AT_CHEST_M = 0.23, 0.275
"""Forearms about a thing of 0.35 m, and where its axis is at the chest: the middle of what is taken."""
CYCLES = 2
"""Of each swing."""
ROOM_RAD = 0.12
"""From the ends of joints, so that each can swing."""
GENTLY = MotionLimits(velocity=0.6, acceleration=4.0, jerk=80.0)
"""The trunk carries the head along, whose joints may turn with 1 rad/s."""
MARGIN_M = 0.0
"""Links may come near each other, as forearms and chest do in a grasp, and must not touch."""


def grasp_postures(arms: Arms, paths: Paths) -> Array:
    """(3, n) rad in which the map is explored: open arms, closed ones, and what they hold drawn to the chest."""
    told = ((OPEN_M, GRASP_HOLD.far_m), (HELD_M, GRASP_HOLD.far_m), (HELD_M, AT_CHEST_M))
    return np.array([arms.posture(paths, dict.fromkeys(SIDES, radius), axis) for radius, axis in told])


def plan_grasp_babbling(ready: RobotWithGains) -> BabblingPlan:
    """Every joint of trunk and arms swings in each posture, from the posture home and back to it.

    Raises SessionError for a robot without such arms, and BabblingError for one that cannot swing anywhere.
    """
    robot, home = ready.robot, np.array(ready.gains.home)
    arms = Arms(robot, home)  # upright: bent forward, the swinging trunk carries the head beyond its limits
    trunk = [joint for joint, name in enumerate(robot.joint_names) if name.startswith("torso_")]
    joints = [*trunk, *(int(joint) for side in SIDES for joint in arms.joints[side])]
    space = FreeSpace(robot, MARGIN_M, home=home)
    told = grasp_postures(arms, arms.plan(GRASP_AROUND))
    postures = np.clip(told, space.lower + ROOM_RAD, space.upper - ROOM_RAD)
    why: dict[int, str] = {}
    free: set[int] = set()
    swings = []
    for posture in postures:
        found = []
        for joint in joints:
            try:
                found.append(plan_joint_sine(space, joint, posture, GENTLY, cycles=CYCLES))
                free.add(joint)
            except BabblingError as error:
                why.setdefault(joint, str(error))
        swings.append(tuple(found))
    if not free:
        raise BabblingError(f"no joint of trunk and arms can swing about a grasp: {next(iter(why.values()))}")
    blocked = {robot.joint_names[joint]: reason for joint, reason in why.items() if joint not in free}
    way = np.array([home, *postures, home])
    rest = np.array([-1, *range(len(postures)), -1], dtype=np.int64)
    about = PosturePlan(postures, way, rest, (), np.zeros((0, len(postures), 3)), np.zeros(0), ())
    return BabblingPlan(about, tuple(swings), blocked)


def learn_grasp_map(seed: int, progress: Progress = lambda _text: None) -> SensoryMotorMap:
    """The map that the skin of the simulated robot learns of itself, through cells, network, driver and guard.

    Neither a kinematic model nor the places of the cells are used: a swing of a joint tells which cells it moves, and
    how much of that along their normals. Raises ExplorationError, BabblingError and SensoryMotorMapError.
    """
    ready = robot_with_gains(ROBOT)
    plan = plan_grasp_babbling(ready)
    exploration = Exploration(ready.robot, finished(LAYOUT, ready.robot.name), seed, ready.gains.home)
    recording = exploration.babble(plan, progress=lambda what, share: progress(f"{what}, {100 * share:.0f} %"))
    exploration.stop()
    found = configure(ready.robot, recording, steps=("topology", "activity"))
    return learn_map(ready.robot, recording, found, sign="motion")
