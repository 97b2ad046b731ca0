# SPDX-License-Identifier: Apache-2.0
"""What the skin knows of its robot's kinematics: axes, frames and cells; as arrays, as URDF, as a Pinocchio model."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from functools import cached_property

import numpy as np
import pinocchio
from numpy.typing import NDArray

from robotskin.selfconfig.kinematics.frames import DenavitHartenberg, denavit_hartenberg, joint_frames
from robotskin.selfconfig.kinematics.screw_tree import ScrewTree
from robotskin.selfconfig.kinematics.unobservable import Unobservable
from robotskin.selfconfig.kinematics.urdf import BASE_LINK, JointBounds, kinematic_urdf, link_name
from robotskin.selfconfig.reconstruction.rigid_patches import RigidPatches

Array = NDArray[np.float64]


@dataclass(frozen=True, eq=False)
class KinematicEstimate:
    """J joints, P patches, N cells; L = J + 1 links, the base first, then the one behind each joint.

    The base frame is that of `base_convention`: z up, on the first axis. A link's frame is that of its joint after
    Denavit and Hartenberg: z along the axis, x along the common normal with the axis before.

    joint_names: (n) of the robot; tree: axes and patches. axes of joints that move no cell are not in it.
    patches: as given; rotation: (N, 3, 3) root_from_cell, refined.
    offset: (N, 3) m/s²; scale: (N, 3).
    noise_factor: estimated over stated deviation of the readings, at least 1.
    swing_weight: (S, N) 1 trusted, near 0 an outlier, 0 missing.
    axis_deviation_rad, point_deviation_m: (J,) standard deviation of each axis across itself, in the base frame, by
        readings taken for independent: too small, since many are wrong alike.
    covariance: (N, 6, 6) of an error (w, d) of base_from_cell at the zero posture: rotation = R exp(w), w in the cell's
        frame, rad; position = p + d, base frame, m. inf on the diagonal, zero beside it, where motion tells nothing.
    unobservable: what no motion tells, each with infinite variance; the base frame itself first.
    """

    joint_names: tuple[str, ...]
    tree: ScrewTree
    patches: RigidPatches
    rotation: Array
    offset: Array
    scale: Array
    noise_factor: float
    swing_weight: Array
    iterations: int
    axis_deviation_rad: Array
    point_deviation_m: Array
    covariance: Array
    unobservable: tuple[Unobservable, ...] = field(default=())

    @property
    def joints(self) -> NDArray[np.int64]:
        """(J,) index of each joint in the robot's posture vector; model, URDF and `tree` keep this order."""
        return self.tree.joints

    @cached_property
    def denavit_hartenberg(self) -> tuple[DenavitHartenberg, ...]:
        """Parameters of every joint against its parent."""
        return denavit_hartenberg(self.tree, self.joint_names)

    @property
    def link_names(self) -> tuple[str, ...]:
        """The L links of the URDF."""
        return (BASE_LINK, *(link_name(self.joint_names[joint]) for joint in self.joints))

    @property
    def link(self) -> NDArray[np.int64]:
        """(N,) index into `link_names` of each cell's link."""
        carrier = np.array([path[-1] + 1 if path else 0 for path in self.tree.paths])
        return carrier[self.patches.patch]

    @cached_property
    def root_from_cell(self) -> Array:
        """(N, 4, 4) metres, the patches' shapes with their rotations refined."""
        pose = self.patches.root_from_cell.copy()
        pose[:, :3, :3] = self.rotation
        return pose

    @cached_property
    def base_from_cell(self) -> Array:
        """(N, 4, 4) metres, all joints at zero."""
        return np.asarray(self.tree.base_from_root[self.patches.patch] @ self.root_from_cell)

    @cached_property
    def base_from_link(self) -> Array:
        """(L, 4, 4) metres, all joints at zero."""
        return np.concatenate([np.eye(4)[None], joint_frames(self.tree, self.denavit_hartenberg)])

    @cached_property
    def link_from_cell(self) -> Array:
        """(N, 4, 4) metres, on the cell's `link`."""
        return np.asarray(np.linalg.inv(self.base_from_link)[self.link] @ self.base_from_cell)

    def base_from_cell_at(self, posture: Array) -> Array:
        """(N, 4, 4) metres, in a posture (n) rad of the robot."""
        return np.asarray(self.tree.base_from_root_at(posture)[self.patches.patch] @ self.root_from_cell)

    def urdf(self, name: str = "selfconfigured", bounds: Mapping[str, JointBounds] | None = None) -> str:
        """The text of a URDF with the J joints, their names and axes.

        Args:
            name: of the robot.
            bounds: by joint name, what the robot's interface tells; unbounded if not given.
        """
        return kinematic_urdf(self.tree, self.denavit_hartenberg, name, bounds or {})

    def model(self, bounds: Mapping[str, JointBounds] | None = None) -> pinocchio.Model:
        """The Pinocchio model of `urdf`, without masses; positions in its own order of joints, see `model.names`."""
        return pinocchio.buildModelFromXML(self.urdf(bounds=bounds))
