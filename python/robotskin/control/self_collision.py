# SPDX-License-Identifier: Apache-2.0
"""Convex hulls of a robot's bodies, and the pairs of them that a self-collision task keeps apart."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray
from scipy.spatial import ConvexHull

from robotskin.model import BASE, RobotDynamics
from robotskin.robots import Robot
from robotskin.skin import SkinState
from robotskin.tasks import SelfCollisionGains, SelfCollisionTask

Hull = tuple[int, NDArray[np.float64]]


def body_hulls(robot: Robot) -> list[Hull]:
    """(joint or BASE, points (m, 3) metres in that joint's frame) of every body with a collision surface."""
    points: dict[int, list[NDArray[np.float64]]] = {}
    for link in robot.links_with("collision"):
        index = robot.link_index(link)
        mesh = robot.link_mesh(link, "collision")
        joint_from_link = robot.core.joint_from_link[index]
        own = mesh.vertices @ joint_from_link[:3, :3].T + joint_from_link[:3, 3]
        points.setdefault(int(robot.core.link_joints[index]), []).append(own)
    return [(joint, _hull_vertices(np.vstack(parts))) for joint, parts in sorted(points.items())]


def self_collision_task(
    robot: Robot, posture: NDArray[np.float64], gains: SelfCollisionGains | None = None
) -> SelfCollisionTask:
    """The task for all pairs of bodies that are two or more joints apart and, in a posture known to be free, apart.

    Args:
        robot: with collision surfaces.
        posture: (n) rad; pairs nearer than the safe distance in it are left out, since they are always near.
        gains: of the task.
    """
    gains = gains or SelfCollisionGains()
    hulls = body_hulls(robot)
    parents = robot.core.joint_parents
    pairs = [
        (a, b)
        for a in range(len(hulls))
        for b in range(a + 1, len(hulls))
        if not _adjacent(hulls[a][0], hulls[b][0], parents)
    ]
    dynamics = RobotDynamics(robot.core)
    dynamics.update(np.ascontiguousarray(posture, dtype=float), np.zeros(robot.joint_count))
    apart = [pair for pair in pairs if _distance_exceeds(robot, hulls, pair, dynamics, gains)]
    return SelfCollisionTask(robot.core, hulls, apart, gains)


def _distance_exceeds(
    robot: Robot, hulls: list[Hull], pair: tuple[int, int], dynamics: RobotDynamics, gains: SelfCollisionGains
) -> bool:
    alone = SelfCollisionTask(robot.core, [hulls[pair[0]], hulls[pair[1]]], [(0, 1)], gains)
    zero = np.zeros(robot.joint_count)
    alone.update(dynamics, zero, zero, SkinState(0), np.zeros(0, dtype=np.float32))
    return not alone.near


def _adjacent(a: int, b: int, parents: NDArray[np.integer]) -> bool:
    """Whether one body is carried by the other with at most one body between them."""

    def above(joint: int) -> list[int]:
        line = [joint]
        for _ in range(2):
            line.append(int(parents[line[-1]]) if line[-1] != BASE else BASE)
        return line

    return a in above(b) or b in above(a)


def _hull_vertices(points: NDArray[np.float64], most: int = 60) -> NDArray[np.float64]:
    """Vertices of the convex hull; where there are more than `most`, those farthest in as many directions."""
    vertices = points[ConvexHull(points).vertices]
    if len(vertices) <= most:
        return np.ascontiguousarray(vertices)
    turn = np.arange(most) * np.pi * (3 - np.sqrt(5))
    height = 1 - 2 * (np.arange(most) + 0.5) / most
    radius = np.sqrt(1 - height**2)
    directions = np.column_stack([radius * np.cos(turn), radius * np.sin(turn), height])
    return np.ascontiguousarray(vertices[np.unique((vertices @ directions.T).argmax(axis=0))])
