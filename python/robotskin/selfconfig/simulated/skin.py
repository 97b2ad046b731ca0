# SPDX-License-Identifier: Apache-2.0
"""A small skin on any robot, with its motion recorded: ground truth for benches and tests of what uses motion."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
import pinocchio
from numpy.typing import NDArray
from scipy.spatial.transform import Rotation

from robotskin.layout.layout import Layout
from robotskin.robots import Robot
from robotskin.selfconfig.babbling.joint_sine import JointSine
from robotskin.selfconfig.kinematics.screw_tree import ScrewTree
from robotskin.selfconfig.readings.gravity_samples import GravitySamples
from robotskin.selfconfig.readings.motion_recording import MotionRecording
from robotskin.selfconfig.reconstruction.observability import UnobservableRotationError
from robotskin.selfconfig.reconstruction.reconstruction import Reconstruction, reconstruct
from robotskin.selfconfig.reconstruction.rigid_patches import RigidPatches
from robotskin.selfconfig.simulated.limb import AccelerometerImperfections, forearm_patch
from robotskin.selfconfig.simulated.motion import AccelerometerFaults, rest_readings, swing_readings
from robotskin.selfconfig.topology.neighbours import NeighbourLists
from robotskin.selfconfig.topology.topology import Topology, explore

Array = NDArray[np.float64]


@dataclass(frozen=True, eq=False)
class SimulatedSkin:
    """N cells whose places are known. link: (N,) index into the robot's links; link_from_cell: (N, 4, 4) metres."""

    robot: Robot
    link: NDArray[np.int64]
    link_from_cell: Array
    topology: Topology

    @classmethod
    def of_layout(cls, robot: Robot, layout: Layout, most: int) -> SimulatedSkin:
        """At most `most` cells of every patch of a layout, nearest by hinges to its root."""
        edges = layout.hinge_edges()
        chosen: list[int] = []
        for patch in layout.patches:
            reached, front = [patch.root], [patch.root]
            while front and len(reached) < most:
                here = front.pop(0)
                beside = edges[edges[:, 0] == here, 2].tolist() + edges[edges[:, 2] == here, 0].tolist()
                fresh = [cell for cell in dict.fromkeys(beside) if cell not in reached][: most - len(reached)]
                reached += fresh
                front += fresh
            chosen += reached
        row = np.full(len(layout), -1)
        row[chosen] = np.arange(len(chosen))
        table = np.tile(np.array([-1, 0]), (len(chosen), 4, 1))
        for a, p, b, q in edges[(row[edges[:, [0, 2]]] >= 0).all(axis=1)].tolist():
            table[row[a], p], table[row[b], q] = (row[b], q + 1), (row[a], p + 1)
        link = np.array([robot.link_index(layout.links[index]) for index in layout.link[chosen]])
        topology = explore(NeighbourLists.from_indices(np.arange(len(chosen)) + 1, table))
        return cls(robot, link, layout.link_from_cell[chosen], topology)

    @classmethod
    def of_sleeves(
        cls, robot: Robot, links: Sequence[str], random: np.random.Generator, columns: int = 4, rows: int = 3
    ) -> SimulatedSkin:
        """A half sleeve of columns x rows cells on each link, turned at random about the link's own origin."""
        poses: list[Array] = []
        link: list[int] = []
        tables: list[NDArray[np.int64]] = []
        for name in links:
            patch = forearm_patch(random, columns, rows)
            middle = patch.patch_from_cell[:, :3, 3].mean(axis=0) * [1.0, 0.0, 0.0]
            turn = np.eye(4)
            turn[:3, :3] = Rotation.random(rng=random).as_matrix()
            turn[:3, 3] = -turn[:3, :3] @ middle
            poses.append(turn @ patch.patch_from_cell)
            table = np.tile(np.array([-1, 0]), (len(patch), 4, 1))
            first = sum(len(one) for one in tables)
            for a, p, b, q in patch.edges.tolist():
                table[a, p], table[b, q] = (first + b, q + 1), (first + a, p + 1)
            tables.append(table)
            link += [robot.link_index(name)] * len(patch)
        key = np.arange(len(link)) + 1
        topology = explore(NeighbourLists.from_indices(key, np.concatenate(tables)))
        return cls(robot, np.array(link), np.concatenate(poses), topology)

    def base_from_cell(self, posture: Array) -> Array:
        """(N, 4, 4) metres, true poses in a posture (n)."""
        return np.asarray(self.robot.base_from_link(posture)[self.link] @ self.link_from_cell)

    def true_tree(self, paths: Sequence[Sequence[int]], patches: RigidPatches) -> ScrewTree:
        """The robot's own axes and the true places of the patches, in its base frame.

        Args:
            paths: of every patch, indices of the robot's joints, inner first.
            patches: of these cells.
        """
        model, data = self.robot.model, self.robot.model.createData()
        columns = pinocchio.computeJointJacobians(model, data, np.zeros(model.nq)).T
        joints = np.array(sorted({joint for path in paths for joint in path}), dtype=np.int64)
        direction = columns[joints, 3:]
        rows = {int(joint): row for row, joint in enumerate(joints)}
        lead = [int(np.argmax(patches.patch == patch)) for patch in range(patches.count)]
        root = self.base_from_cell(np.zeros(model.nq))[lead] @ np.linalg.inv(patches.root_from_cell[lead])
        paths_in_rows = tuple(tuple(rows[joint] for joint in path) for path in paths)
        return ScrewTree(joints, direction, np.cross(direction, columns[joints, :3]), paths_in_rows, root)

    def rest_readings(
        self,
        postures: Array,
        faults: AccelerometerFaults,
        random: np.random.Generator,
        imperfections: AccelerometerImperfections = AccelerometerImperfections(),  # noqa: B008 - frozen
        samples: int = 16,
    ) -> GravitySamples:
        """What the cells feel at rest in each of the postures (K, n)."""
        raw = rest_readings(
            self.robot, self.link, self.link_from_cell, postures, faults, random, imperfections, samples
        )
        return GravitySamples.from_raw(raw)

    def swings(
        self,
        swings: Sequence[JointSine],
        faults: AccelerometerFaults,
        random: np.random.Generator,
        imperfections: AccelerometerImperfections = AccelerometerImperfections(),  # noqa: B008 - frozen
    ) -> list[MotionRecording]:
        """What the cells feel in each swing."""
        return [
            swing_readings(self.robot, self.link, self.link_from_cell, swing, faults, random, imperfections)
            for swing in swings
        ]


def reconstruct_all(topology: Topology, samples: GravitySamples) -> tuple[RigidPatches, Array, Array]:
    """Every patch that gravity tells the shape of; the others as lone cells.

    Returns:
        the patches, and offset (N, 3) m/s² and scale (N, 3) of the accelerometers, 0 and 1 where not found.
    """
    found: list[Reconstruction] = []
    count = len(topology.cell)
    offset, scale = np.zeros((count, 3)), np.ones((count, 3))
    for patch in range(len(topology.root)):
        try:
            one = reconstruct(topology, samples, patch)
        except UnobservableRotationError:
            continue
        found.append(one)
        offset[one.cells], scale[one.cells] = one.offset, one.scale
    return RigidPatches.of(topology, found), offset, scale
