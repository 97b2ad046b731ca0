# SPDX-License-Identifier: Apache-2.0
"""Frames by convention: that of the base, and one on every joint after Denavit and Hartenberg."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray
from scipy.spatial.transform import Rotation

from robotskin.selfconfig.kinematics.screw_tree import ScrewTree, common_normal

Array = NDArray[np.float64]

NEARLY_PARALLEL = 0.05
"""Sine of the angle below which two axes count as parallel where a frame is chosen."""


@dataclass(frozen=True)
class DenavitHartenberg:
    """From the frame of a joint's parent to its own: Rz(theta) Tz(d) Tx(a) Rx(alpha) Ry(beta), all joints at zero.

    z of every frame is the axis of its joint, x the common normal with the axis before, from that one to this. Where
    both are nearly parallel and d would be ill-defined, d is zero and beta is not (Hayati and Mirmirani, J. Robotic
    Systems 2(4), 1985); elsewhere beta is zero (Denavit and Hartenberg, 1955). A joint's own turn is added to the next
    theta.

    joint: name; theta_rad, alpha_rad, beta_rad; d_m, a_m in metres.
    """

    joint: str
    theta_rad: float
    d_m: float
    a_m: float
    alpha_rad: float
    beta_rad: float = 0.0

    def parent_from_joint(self) -> Array:
        """(4, 4) metres."""
        frame = np.eye(4)
        first = Rotation.from_rotvec([0.0, 0.0, self.theta_rad])
        frame[:3, :3] = (first * Rotation.from_euler("XY", [self.alpha_rad, self.beta_rad])).as_matrix()
        frame[:3, 3] = first.apply([self.a_m, 0.0, self.d_m])
        return frame


def base_convention(tree: ScrewTree, base_from_cell: Array) -> Array:
    """(4, 4) from the base frame of a tree to that which the project chooses.

    z is opposite to gravity. The origin lies on the axis of the innermost joint of the largest tree, at the foot of the
    common normal with the next axis that is not parallel to it; x is that axis seen from above (or the common normal,
    where it is vertical). With a single axis, the cells' mean place takes the next axis's part.

    Args:
        tree: z of its base frame opposite to gravity.
        base_from_cell: (N, 4, 4) metres.
    """
    sizes = np.bincount(tree.trees, minlength=len(tree.joints))
    first = int(np.argmax(sizes))
    direction, point = tree.direction[first], tree.point[first]
    others = [row for row in range(len(tree.joints)) if tree.trees[row] == first and row != first]
    others.sort(key=lambda row: len(_ancestors(tree, row)))
    crossing = [row for row in others if np.linalg.norm(np.cross(direction, tree.direction[row])) > NEARLY_PARALLEL]
    middle = base_from_cell[:, :3, 3].mean(axis=0)
    if crossing:
        origin, far = common_normal(direction, point, tree.direction[crossing[0]], tree.point[crossing[0]])
        ways = [tree.direction[crossing[0]], far - origin]
    else:
        target = tree.point[others[0]] if others else middle
        origin = point + direction * (direction @ (target - point))
        ways = [target - origin]
    x = next((way for way in [*ways, middle - origin] if np.hypot(way[0], way[1]) > 0.03), np.array([1.0, 0.0, 0.0]))
    x = np.array([x[0], x[1], 0.0]) / np.hypot(x[0], x[1])
    frame = np.eye(4)
    frame[:3, :3] = np.stack([x, np.cross([0.0, 0.0, 1.0], x), [0.0, 0.0, 1.0]], axis=1)
    frame[:3, 3] = origin
    return np.asarray(np.linalg.inv(frame))


def denavit_hartenberg(tree: ScrewTree, names: tuple[str, ...]) -> tuple[DenavitHartenberg, ...]:
    """Parameters of every joint, against its parent or, for one on the base, against the base frame.

    Args:
        tree: of J joints.
        names: (n) of the robot's joints.
    """
    frames = np.tile(np.eye(4), (len(tree.joints), 1, 1))
    table: dict[int, DenavitHartenberg] = {}
    parent = tree.parent
    for row in _outward(tree):
        before = frames[parent[row]] if parent[row] >= 0 else np.eye(4)
        inverse = np.linalg.inv(before)
        direction = inverse[:3, :3] @ tree.direction[row]
        point = inverse[:3, :3] @ tree.point[row] + inverse[:3, 3]
        table[row] = _parameters(names[tree.joints[row]], direction, point)
        frames[row] = before @ table[row].parent_from_joint()
    return tuple(table[row] for row in range(len(tree.joints)))


def joint_frames(tree: ScrewTree, table: tuple[DenavitHartenberg, ...]) -> Array:
    """(J, 4, 4) base_from_joint at the zero posture, by the parameters of each joint."""
    frames = np.tile(np.eye(4), (len(table), 1, 1))
    parent = tree.parent
    for row in _outward(tree):
        before = frames[parent[row]] if parent[row] >= 0 else np.eye(4)
        frames[row] = before @ table[row].parent_from_joint()
    return frames


def tree_of_parameters(tree: ScrewTree, table: tuple[DenavitHartenberg, ...]) -> ScrewTree:
    """The tree with other parameters; every patch keeps its place on the frame of the joint that carries it."""
    unnamed = ("",) * (int(tree.joints.max(initial=0)) + 1)
    old = joint_frames(tree, denavit_hartenberg(tree, unnamed))
    new = joint_frames(tree, table)
    pose = tree.base_from_root.copy()
    for patch, path in enumerate(tree.paths):
        if path:
            pose[patch] = new[path[-1]] @ np.linalg.inv(old[path[-1]]) @ pose[patch]
    return replace(tree, direction=new[:, :3, 2], point=new[:, :3, 3], base_from_root=pose)


def _parameters(name: str, direction: Array, point: Array) -> DenavitHartenberg:
    """Of a line given in the frame before."""
    across = float(np.hypot(direction[0], direction[1]))
    if across > NEARLY_PARALLEL:
        z = np.array([0.0, 0.0, 1.0])
        near, far = common_normal(z, np.zeros(3), direction, point)
        length = float(np.linalg.norm(far - near))
        x = (far - near) / length if length > 1e-9 else np.cross(z, direction) / across
        alpha = np.arctan2(np.cross(z, direction) @ x, direction[2])
        return DenavitHartenberg(name, float(np.arctan2(x[1], x[0])), float(near[2]), length, float(alpha))
    crossing = point - direction * (point[2] / direction[2])
    length = float(np.hypot(crossing[0], crossing[1]))
    theta = float(np.arctan2(crossing[1], crossing[0])) if length > 1e-6 else 0.0
    turned = Rotation.from_rotvec([0.0, 0.0, -theta]).apply(direction)
    alpha, beta = np.arctan2(-turned[1], turned[2]), np.arcsin(np.clip(turned[0], -1.0, 1.0))
    return DenavitHartenberg(name, theta, 0.0, length, float(alpha), float(beta))


def _outward(tree: ScrewTree) -> list[int]:
    """Rows of the joints, parents first."""
    return sorted(range(len(tree.joints)), key=lambda row: len(_ancestors(tree, row)))


def _ancestors(tree: ScrewTree, row: int) -> list[int]:
    parent, found = tree.parent, []
    while parent[row] >= 0:
        row = int(parent[row])
        found.append(row)
    return found
