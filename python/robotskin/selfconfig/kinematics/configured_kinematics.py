# SPDX-License-Identifier: Apache-2.0
"""The kinematics step of the self-configuration: from patches and swings to axes, and what that says of the patches.

In: a recording and the reconstructed patches. Out: the kinematic estimate, and how far its axes lie from those of a
nominal model.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.optimize import least_squares
from scipy.spatial.transform import Rotation

from robotskin.model import JointKind, RobotDynamics
from robotskin.robots import Robot
from robotskin.selfconfig.kinematics.estimate import KinematicEstimate
from robotskin.selfconfig.kinematics.kinematics import estimate_kinematics
from robotskin.selfconfig.readings.gravity_samples import GravitySamples
from robotskin.selfconfig.readings.motion_recording import MotionRecording
from robotskin.selfconfig.reconstruction.reconstruction import Reconstruction
from robotskin.selfconfig.reconstruction.rigid_patches import RigidPatches
from robotskin.selfconfig.topology.topology import Topology

Array = NDArray[np.float64]


def kinematics_from(
    robot: Robot,
    recordings: Sequence[MotionRecording],
    rest_posture: Array,
    samples: GravitySamples,
    topology: Topology,
    shapes: Sequence[Reconstruction],
    activity: NDArray[np.bool_],
) -> KinematicEstimate:
    """Axes of all revolute joints, from swings and rests alone; of the robot only the kinds of joints are used.

    Sliding joints, such as those of a wheeled base, are taken to have stood still between swings of others.

    Args:
        robot: whose joints swung.
        recordings: swings of the N cells of the topology, in its order.
        rest_posture: (K, n) of the rests; samples: what was felt in them.
        samples: see rest_posture.
        topology: of N cells.
        shapes: of patches; cells of other patches count as lone, held by their hinges.
        activity: (n, N) which joint moves which cell.

    Raises:
        KinematicsError: too little motion, or no settled result.
        ValueError: an activity that no open chain has.
    """
    revolute = np.array([kind is JointKind.revolute for kind in robot.core.joint_kinds], dtype=bool)
    count = len(topology.cell)
    offset, scale = np.zeros((count, 3)), np.ones((count, 3))
    for shape in shapes:
        offset[shape.cells], scale[shape.cells] = shape.offset, shape.scale
    swings = [one for one in recordings if revolute[one.swing.joint]]
    swung = {one.swing.joint for one in swings}
    return estimate_kinematics(
        swings,
        RigidPatches.of(topology, shapes),
        joint_names=robot.joint_names,
        rests=(rest_posture, samples),
        activity={joint: activity[joint] for joint in sorted(swung)},
        offset=offset,
        scale=scale,
    )


@dataclass(frozen=True)
class AxisDifference:
    """How far an estimated axis lies from the nominal one once the base frames are aligned.

    joint: name; angle_rad: between the lines; distance_m: between the lines where they are nearest.
    deviation_rad: stated of the estimate.
    """

    joint: str
    angle_rad: float
    distance_m: float
    deviation_rad: float


def against_nominal(estimate: KinematicEstimate, robot: Robot) -> tuple[AxisDifference, ...]:
    """Every estimated axis against the nominal model, in joint order.

    The base frame that the skin chose by convention differs from the robot's by a turn about the vertical and a shift,
    which no motion tells; they are fitted first, for each limb of a robot that branches, since limbs behind a vertical
    joint can be turned about it against each other without any reading changing.

    Args:
        estimate: of the kinematics.
        robot: nominal model.
    """
    dynamics = RobotDynamics(robot.core)
    dynamics.update(np.zeros(robot.joint_count), np.zeros(robot.joint_count))
    joints = estimate.joints
    linear, axis = np.split(dynamics.joint_motions[joints], 2, axis=1)
    point = np.cross(axis, linear)
    direction, at = estimate.tree.direction.copy(), estimate.tree.point.copy()
    for limb in limbs(estimate.tree.parent):
        direction[limb], at[limb] = _aligned(direction[limb], at[limb], axis[limb], point[limb])
    found = []
    for row, joint in enumerate(joints):
        across = np.cross(direction[row], axis[row])
        sine = float(np.linalg.norm(across))
        gap = at[row] - point[row]
        # Nearly parallel lines have no telling nearest points; their distance is taken across them.
        distance = float(np.linalg.norm(np.cross(gap, axis[row])))
        if sine > 0.05:
            distance = abs(float(gap @ across)) / sine
        angle = float(np.arctan2(sine, abs(direction[row] @ axis[row])))
        found.append(AxisDifference(robot.joint_names[joint], angle, distance, float(estimate.axis_deviation_rad[row])))
    return tuple(found)


def limbs(parent: NDArray[np.integer]) -> list[list[int]]:
    """Rows of joints by limb: what several limbs hang on is a limb of its own.

    Args:
        parent: (J,) row of the joint that carries each joint, -1 on the base.
    """
    count = len(parent)
    above_of = [int(row) for row in parent]
    children = np.bincount(parent[parent >= 0], minlength=count)
    trunk = np.zeros(count, dtype=bool)
    for fork in np.flatnonzero(children > 1):
        above = int(fork)
        while above >= 0:
            trunk[above], above = True, above_of[above]
    found: dict[int, list[int]] = {}
    for row in range(count):
        top = row
        while not trunk[row] and above_of[top] >= 0 and not trunk[above_of[top]]:
            top = above_of[top]
        found.setdefault(-1 if trunk[row] else top, []).append(row)
    return list(found.values())


def _aligned(direction: Array, at: Array, axis: Array, point: Array) -> tuple[Array, Array]:
    """Lines (J, 3) turned about the vertical and shifted onto the nominal ones as far as that goes."""

    def placed(x: Array) -> tuple[Array, Array]:
        turn = Rotation.from_rotvec([0.0, 0.0, x[0]]).as_matrix()
        return direction @ turn.T, at @ turn.T + x[1:]

    def residuals(x: Array) -> Array:
        turned, moved = placed(x)
        return np.concatenate([np.cross(turned, axis).ravel(), np.cross(moved - point, axis).ravel()])

    starts = [least_squares(residuals, [angle, 0.0, 0.0, 0.0]) for angle in np.arange(8) * np.pi / 4]
    return placed(min(starts, key=lambda fit: float(fit.cost)).x)
