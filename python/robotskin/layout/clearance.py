# SPDX-License-Identifier: Apache-2.0
"""Room for skin: how far places on a link stay from the neighbouring links over the whole joint range."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np
import pinocchio
from numpy.typing import NDArray
from scipy import ndimage
from scipy.spatial import cKDTree

from robotskin.layout.surface import DistanceField, LinkSurface, distance_field

if TYPE_CHECKING:
    from robotskin.robots import Robot

Array = NDArray[np.float64]

JOINT_STEP_RAD = np.radians(6.0)
"""Spacing of the sampled joint positions; at 0.15 m from the axis a point moves 16 mm between two of them."""
BOX_MARGIN_M = 0.015
"""Room that a neighbour's grid leaves around its mesh."""
SAMPLES_OF_A_CHAIN = 300
"""Random postures where several joints without a mesh lie between two links."""


def link_joint(robot: Robot, link: str) -> int:
    """Index of the Pinocchio joint that carries a link; UnknownNameError for a link the robot does not have."""
    robot.link_index(link)
    return int(robot.model.frames[robot.model.getBodyId(link)].parentJoint)


def joint_positions(model: pinocchio.Model, joint: int) -> Array:
    """(Q, nv) tangent displacements from neutral that sample one joint's range; a full turn where it has no limits."""
    size = model.joints[joint].nv
    if model.joints[joint].nq == size == 1:
        index = model.idx_qs[joint]
        low, high = float(model.lowerPositionLimit[index]), float(model.upperPositionLimit[index])
        # Beyond one turn a revolute joint brings nothing new; so does a range without limits.
        if not high - low < 2 * np.pi:
            low, high = -np.pi, np.pi
        neutral = float(pinocchio.neutral(model)[model.idx_qs[joint]])
        count = max(2, int(np.ceil((high - low) / JOINT_STEP_RAD)) + 1)
        return np.linspace(low, high, count)[:, None] - neutral
    if size == 1:
        return np.linspace(-np.pi, np.pi, int(2 * np.pi / JOINT_STEP_RAD) + 1)[:, None]
    return np.zeros((1, size))


def postures(model: pinocchio.Model, path: list[int], seed: int) -> Array:
    """(Q, nq) configurations that sample the joints of a path, all others neutral."""
    neutral = pinocchio.neutral(model)
    ranges = [joint_positions(model, joint) for joint in path]
    if len(path) == 1:
        choices = [ranges[0]]
        count = len(ranges[0])
    else:
        random = np.random.default_rng(seed)
        count = SAMPLES_OF_A_CHAIN
        choices = [samples[random.integers(len(samples), size=count)] for samples in ranges]
    result = np.empty((count, model.nq))
    for index in range(count):
        velocity = np.zeros(model.nv)
        for joint, samples in zip(path, choices, strict=True):
            start = model.idx_vs[joint]
            velocity[start : start + model.joints[joint].nv] = samples[index]
        result[index] = pinocchio.integrate(model, neutral, velocity)
    return result


def neighbouring_links(robot: Robot, link: str) -> dict[str, list[int]]:
    """Links with a mesh next to a link, and the joints between.

    Across a joint that carries no mesh the search goes on to the next one.
    """
    model = robot.model
    meshed: dict[int, list[str]] = {}
    for name in robot.links_with("collision"):
        meshed.setdefault(link_joint(robot, name), []).append(name)
    start = link_joint(robot, link)
    children: dict[int, list[int]] = {}
    for joint in range(1, model.njoints):
        children.setdefault(int(model.parents[joint]), []).append(joint)
    found: dict[str, list[int]] = {other: [] for other in meshed.get(start, []) if other != link}
    # Each entry: a carrying joint, the joint it was reached from and the moving joints in between.
    stack: list[tuple[int, int, list[int]]] = [(start, -1, [])]
    while stack:
        here, origin, path = stack.pop()
        steps = [(child, child) for child in children.get(here, [])]
        if here > 0:
            steps.append((int(model.parents[here]), here))
        for there, moving in steps:
            if there == origin:
                continue
            if meshed.get(there):
                found |= {name: [*path, moving] for name in meshed[there]}
            elif len(path) < 3:
                stack.append((there, here, [*path, moving]))
    return found


@dataclass(frozen=True)
class Clearance:
    """Distance of points fixed to a link from the neighbouring links, least over the joint range.

    neighbours: for each neighbouring link its name, its field and (Q, 4, 4) neighbour_from_link.
    """

    neighbours: tuple[tuple[str, DistanceField, Array], ...]

    @classmethod
    def of(cls, robot: Robot, link: str, fields: dict[str, DistanceField], seed: int = 0) -> Clearance:
        """Sample the joints between a link and its neighbours.

        Args:
            robot: with its Pinocchio model and meshes.
            link: name.
            fields: distance fields made before, by link; filled with those that were missing.
            seed: of random postures.
        """
        model = robot.model
        data = model.createData()
        frame = model.getBodyId(link)
        entries = []
        for name, path in neighbouring_links(robot, link).items():
            other = model.getBodyId(name)
            configurations = postures(model, path, seed) if path else pinocchio.neutral(model)[None]
            transforms = np.empty((len(configurations), 4, 4))
            for index, configuration in enumerate(configurations):
                pinocchio.forwardKinematics(model, data, configuration)
                pinocchio.updateFramePlacement(model, data, frame)
                pinocchio.updateFramePlacement(model, data, other)
                transforms[index] = (data.oMf[other].inverse() * data.oMf[frame]).homogeneous
            if name not in fields:
                mesh = robot.link_mesh(name)
                extent = float(np.prod(mesh.extents + 2 * BOX_MARGIN_M))
                fields[name] = distance_field(
                    mesh, float(np.clip((extent / 4e5) ** (1 / 3), 0.002, 0.005)), BOX_MARGIN_M
                )
            entries.append((name, fields[name], transforms))
        return cls(tuple(entries))

    def at(self, points: Array) -> Array:
        """(N,) metres for points (N, 3) in the link frame; infinite for a link without neighbours.

        Beyond 15 mm it is a lower bound: what is that far from a neighbour needs no exact distance.
        """
        least = np.full(len(points), np.inf)
        for _, field, transforms in self.neighbours:
            corners = np.stack([field.origin, field.origin + field.step * (np.array(field.value.shape) - 1)])
            # A ball around the neighbour's box keeps most points of a long link from being looked at closer.
            centres = np.einsum("qji,qj->qi", transforms[:, :3, :3], corners.mean(axis=0) - transforms[:, :3, 3])
            radius = 0.5 * float(np.linalg.norm(corners[1] - corners[0]))
            outside_ball = cKDTree(centres).query(points)[0] - radius
            least = np.where(outside_ball > 0, np.minimum(least, outside_ball + BOX_MARGIN_M), least)
            inner = np.flatnonzero(outside_ball <= 0)
            least[inner] = self._at_neighbour(points[inner], least[inner], field, transforms)
        return least

    @staticmethod
    def _at_neighbour(points: Array, least: Array, field: DistanceField, transforms: Array) -> Array:
        """The smaller of least (N,) and the distance of points (N, 3) from one neighbour, over its transforms."""
        low, high = field.origin, field.origin + field.step * (np.array(field.value.shape) - 1)
        for transform in transforms:
            moved = points @ transform[:3, :3].T + transform[:3, 3]
            # Outside the neighbour's box the distance to the box is a lower bound, and enough of an answer.
            beyond = np.maximum(np.maximum(low - moved, moved - high), 0.0)
            bound = np.sqrt((beyond**2).sum(axis=1))
            closer = np.flatnonzero((bound <= 0.0) & (least > -field.step))
            np.minimum(least, np.where(bound > 0.0, bound + BOX_MARGIN_M, np.inf), out=least)
            least[closer] = np.minimum(least[closer], field.at(moved[closer]))
        return least

    def near(self, surface: LinkSurface, band: float = 0.010, step: float = 0.004) -> DistanceField:
        """The same as a field on a grid, made once so that growth can ask often.

        Args:
            surface: of the link; the field is right within band of the middle of its skin, and elsewhere continued.
            band: metres.
            step: of the grid, metres; linear interpolation overstates distances by less than step^2 / (8 distance).
        """
        low, high = surface.mesh.bounds[0] - 0.02, surface.mesh.bounds[1] + 0.02
        shape = np.ceil((high - low) / step).astype(int) + 1
        centres = np.indices(shape).reshape(3, -1).T * step + low
        wanted = np.abs(surface.smooth.at(centres) - 0.5 * surface.height) < band
        value = np.full(len(centres), np.inf)
        value[wanted] = np.minimum(self.at(centres[wanted]), 1.0)
        nearest = ndimage.distance_transform_edt(~wanted.reshape(shape), return_distances=False, return_indices=True)
        return DistanceField(value.reshape(shape)[tuple(nearest)].astype(np.float32), low, step)
