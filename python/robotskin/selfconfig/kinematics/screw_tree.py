# SPDX-License-Identifier: Apache-2.0
"""A robot as its skin can know it: the axes of its joints as lines in space, and which of them carry which patch.

Product of exponentials: T(q) = exp(ξ₁ q₁) … exp(ξₘ qₘ) T(0), every line ξ given in the base frame at the zero posture.
It has no singularity for parallel axes and needs no link frames.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from robotskin.selfconfig.common.rotations import cross_matrix

Array = NDArray[np.float64]


@dataclass(frozen=True, eq=False)
class ScrewTree:
    """J revolute joints and P patches. Base frame: z opposite to gravity.

    joints: (J,) index of each in the posture vector of the robot.
    direction: (J, 3) unit vectors; point: (J, 3) metres; both in the base frame with all joints at zero.
    paths: for each patch, the rows of the joints that carry it, the innermost first; empty on the base.
    base_from_root: (P, 4, 4) metres, with all joints at zero.
    """

    joints: NDArray[np.int64]
    direction: Array
    point: Array
    paths: tuple[tuple[int, ...], ...]
    base_from_root: Array

    @property
    def parent(self) -> NDArray[np.int64]:
        """(J,) row of the joint that carries each joint, −1 for one on the base."""
        parent = np.full(len(self.joints), -1)
        for path in self.paths:
            parent[list(path[1:])] = path[:-1]
        return parent

    @property
    def trees(self) -> NDArray[np.int64]:
        """(J,) row of the innermost joint that carries each joint, itself where none does."""
        parent = self.parent
        top = np.arange(len(parent))
        for row in range(len(parent)):
            while parent[top[row]] >= 0:
                top[row] = parent[top[row]]
        return top

    def prefixes(self, path: tuple[int, ...], postures: Array) -> Array:
        """Motion of what the first joints of a path carry, from the zero posture to each of S postures (S, n).

        Returns:
            (m + 1, S, 4, 4) for none of the m joints, the first, the first two, … all.
        """
        motion = np.tile(np.eye(4), (len(postures), 1, 1))
        result = [motion]
        for row in path:
            motion = motion @ turns(self.direction[row], self.point[row], postures[:, self.joints[row]])
            result.append(motion)
        return np.array(result)

    def base_from_root_at(self, posture: Array) -> Array:
        """(P, 4, 4) metres, in a posture (n) of the robot."""
        moved = {path: self.prefixes(path, posture[None])[-1, 0] for path in set(self.paths)}
        return np.asarray(np.array([moved[path] for path in self.paths]) @ self.base_from_root)

    def seen_from(self, new_from_base: Array) -> ScrewTree:
        """The same in another base frame; (4, 4)."""
        rotation, shift = new_from_base[:3, :3], new_from_base[:3, 3]
        return replace(
            self,
            direction=self.direction @ rotation.T,
            point=self.point @ rotation.T + shift,
            base_from_root=new_from_base @ self.base_from_root,
        )


def line_twist(direction: Array, point: Array) -> Array:
    """(6,) twist of one rad/s about a line: linear part −a × p, angular part a."""
    return np.concatenate([-np.cross(direction, point), direction])


def turns(direction: Array, point: Array, angle: Array) -> Array:
    """(S, 4, 4) of space about a line, by angles (S,) rad: Rodrigues' formula, and t = p − R p."""
    cross = cross_matrix(direction)
    sine, cosine = np.sin(angle)[:, None, None], np.cos(angle)[:, None, None]
    motion = np.tile(np.eye(4), (len(angle), 1, 1))
    motion[:, :3, :3] += sine * cross + (1.0 - cosine) * (cross @ cross)
    motion[:, :3, 3] = point - motion[:, :3, :3] @ point
    return motion


def actions(motion: Array) -> Array:
    """(..., 6, 6) that turn a twist, linear part first, into what it is after a motion (..., 4, 4): the adjoint."""
    rotation = motion[..., :3, :3]
    result = np.zeros((*motion.shape[:-2], 6, 6))
    result[..., :3, :3] = result[..., 3:, 3:] = rotation
    result[..., :3, 3:] = cross_matrix(motion[..., :3, 3]) @ rotation
    return result


def line_basis(direction: Array, point: Array) -> Array:
    """(6, 4) twists that turn a line about its point, and shift it, each across itself."""
    first, second = across(direction)
    basis = np.zeros((6, 4))
    for column, axis in enumerate((first, second)):
        basis[:3, column], basis[3:, column] = np.cross(point, axis), axis
        basis[:3, 2 + column] = axis
    return basis


def pose_basis(position: Array) -> Array:
    """(6, 6) twists that shift a pose, and turn it about its own origin, along the base's axes."""
    basis = np.eye(6)
    basis[:3, 3:] = cross_matrix(position)
    return basis


def across(direction: Array) -> Array:
    """(2, 3) two unit vectors that with a unit vector make a right-handed triad."""
    first = np.eye(3)[np.argmin(np.abs(direction))]
    first = first - direction * (first @ direction)
    first /= np.linalg.norm(first)
    return np.array([first, np.cross(direction, first)])


def common_normal(direction_a: Array, point_a: Array, direction_b: Array, point_b: Array) -> tuple[Array, Array]:
    """(3,) and (3,): the nearest points of two lines; for parallel ones, the foot of b's point, and b's point."""
    normal = np.cross(direction_a, direction_b)
    if normal @ normal < 1e-4:
        return point_a + direction_a * (direction_a @ (point_b - point_a)), point_b
    way = np.linalg.solve(np.stack([direction_a, -direction_b, normal], axis=1), point_b - point_a)
    return point_a + way[0] * direction_a, point_b + way[1] * direction_b
