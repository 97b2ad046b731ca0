# SPDX-License-Identifier: Apache-2.0
"""The whole self-configuration on recorded data (paper, figure 4): from a babbling to a skin model.

In: a recording and the robot's kinematic model. Out: `Configuration`, and from it the layout of every cell whose place
is known. Each step is a function of its own; this file only calls them in the paper's order and keeps their times.
"""

from __future__ import annotations

import time
from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from robotskin.errors import UnknownNameError
from robotskin.robots import Robot
from robotskin.selfconfig.common.one_thread import one_thread
from robotskin.selfconfig.configuration import Configuration, ConfigurationError, ConfiguredPatch
from robotskin.selfconfig.kinematics.activity import kinematic_tree
from robotskin.selfconfig.kinematics.configured_kinematics import kinematics_from
from robotskin.selfconfig.kinematics.kinematics import KinematicsError
from robotskin.selfconfig.patch_steps import Progress, localise_patches, reconstruct_patches
from robotskin.selfconfig.readings.recording import BabblingRecording
from robotskin.selfconfig.recorded import measure_activity, ports_in, rows_of, samples_in, swings_in
from robotskin.selfconfig.topology.neighbours import NeighbourLists
from robotskin.selfconfig.topology.topology import Topology, explore

STEPS = ("topology", "activity", "reconstruction", "kinematics", "localisation", "map")


@one_thread
def configure(
    robot: Robot,
    recording: BabblingRecording,
    *,
    steps: Sequence[str] = STEPS,
    progress: Progress | None = None,
) -> Configuration:
    """All steps from a recording to placed cells.

    Args:
        robot: kinematic model, z of the base frame up, with the recording's joints.
        recording: of the babbling.
        steps: which to take of `STEPS`; topology and activity always are, and "map" is taken by `learn_map`.
        progress: told what is done.

    Raises:
        ConfigurationError: a recording of other joints, or a step without one that it builds on.
        UnknownNameError: no such step.
    """
    require_steps(steps)
    require_joints(robot, recording)
    tell = progress or (lambda _step, _share: None)
    seconds: dict[str, float] = {}
    start = time.perf_counter()

    def lap(step: str) -> None:
        nonlocal start
        now = time.perf_counter()
        seconds[step], start = now - start, now

    tell("activity", 0.0)
    activity, swung = measure_activity(recording, sways=robot.standing is not None)
    lap("activity")
    tell("topology", 0.0)
    topology = rigid_topology(recording.lists, activity)
    order = rows_of(recording, topology)
    activity = activity[:, order]
    try:
        tree = kinematic_tree(activity)
    except ValueError:
        tree = None
    lap("topology")
    patches = tuple(ConfiguredPatch(topology.cells_of(patch)) for patch in range(len(topology.root)))
    if "reconstruction" in steps:
        patches = reconstruct_patches(topology, samples_in(recording, order), progress)
        lap("reconstruction")
    kinematics, trouble = None, ""
    if "kinematics" in steps:
        tell("kinematics", 0.0)
        shapes = [patch.reconstruction for patch in patches if patch.reconstruction is not None]
        try:
            kinematics = kinematics_from(
                robot,
                swings_in(recording, order),
                recording.rest_posture,
                samples_in(recording, order),
                topology,
                shapes,
                activity,
            )
        except (KinematicsError, ValueError) as error:
            trouble = str(error)
        lap("kinematics")
    if "localisation" in steps:
        patches = localise_patches(robot, recording, order, patches, activity, swung, progress)
        lap("localisation")
    ports = ports_in(recording, order)
    return Configuration(robot.name, topology, activity, swung, tree, patches, ports, kinematics, trouble, seconds)


def require_steps(steps: Sequence[str]) -> None:
    """Refuse steps that do not exist, or that lack one they build on, before anything moves.

    Raises:
        ConfigurationError: kinematics or localisation without reconstruction.
        UnknownNameError: no such step.
    """
    for step in steps:
        if step not in STEPS:
            raise UnknownNameError("step", step, STEPS)
        if step in ("kinematics", "localisation") and "reconstruction" not in steps:
            raise ConfigurationError(f"step {step}: builds on reconstruction, which is not among {', '.join(steps)}")


def require_joints(robot: Robot, recording: BabblingRecording) -> None:
    """Refuse a recording of other joints than the robot's, with a ConfigurationError that names both."""
    if recording.joint_names != robot.joint_names:
        raise ConfigurationError(
            f"recording of {recording.robot} with joints {', '.join(recording.joint_names)}; "
            f"{robot.name} has {', '.join(robot.joint_names)}"
        )


def rigid_topology(lists: NeighbourLists, activity: NDArray[np.bool_]) -> Topology:
    """The topology of what is rigid: a cable between cells that do not move alike is no hinge.

    Args:
        lists: N neighbour reports.
        activity: (n, N) in their order.
    """
    row = {int(key): number for number, key in enumerate(lists.cell)}
    facing = np.vectorize(lambda key: row.get(int(key), -1), otypes=[np.int64])(lists.neighbour)
    silent = np.asarray(~activity.any(axis=0), dtype=bool)
    apart = (activity[:, :, None] != activity[:, facing]).any(axis=0) & (facing >= 0)
    # A cell that gave no reading moves with whatever it hangs on.
    apart &= ~silent[:, None] & ~silent[facing]
    return explore(NeighbourLists(lists.cell, np.where(apart, 0, lists.neighbour), lists.port))
