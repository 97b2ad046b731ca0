# SPDX-License-Identifier: Apache-2.0
"""The joints below a link, in the integers in which a cell keeps them and computes its own torques."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray
from scipy.spatial.transform import Rotation

from robotskin import firmware
from robotskin.errors import RobotskinError
from robotskin.model import JointKind
from robotskin.robots.robot import Robot


class ChainError(RobotskinError):
    """A chain that no cell can compute; the message names the link, the value and what is possible."""


LONGEST_M = firmware.CHAIN_REACH / 2.0**firmware.LENGTH_BITS * 2.0**firmware.LENGTH_EXPONENT_MAX
"""From a joint to a cell."""


@dataclass(frozen=True)
class Chain:
    """The n joints from a robot's base to a link, each turning about or sliding along the z axis of its own frame.

    The frames are the robot's joint frames, turned so that the joint's axis becomes z; frame l's pose in frame l - 1
    at position 0 is `before_from_joint[l]`. Cheng et al. 2019, section IV-B6.
    """

    link: str
    joints: tuple[int, ...]
    """(n,) indices of the robot's joints, base first."""
    before_from_joint: NDArray[np.float64]
    """(n, 4, 4) metres; the first is in the base frame."""
    joint_from_link: NDArray[np.float64]
    """(4, 4) the link in the frame of the last joint."""
    prismatic: NDArray[np.bool_]
    """(n,)"""
    slide_m: float
    """The longest way that a sliding joint may be from its zero, of those that the torque of another depends on.

    Where the first joints of a chain slide, as a mobile base does, no torque depends on how far: nothing turns below.
    """

    @classmethod
    def to(cls, robot: Robot, link: str) -> "Chain":
        """The chain below a link. Raises ChainError for one that no joint moves, or too many do."""
        model = robot.core
        index = robot.link_index(link)
        joints: list[int] = []
        joint = int(model.link_joints[index])
        while joint >= 0:
            joints.insert(0, joint)
            joint = int(model.joint_parents[joint])
        if not 1 <= len(joints) <= firmware.CHAIN_JOINTS:
            raise ChainError(
                f"{link} of {robot.name} has {len(joints)} joints between it and the base, "
                f"where cells sum over 1 to {firmware.CHAIN_JOINTS}; "
                f"let the host sum the torques: robotskin run {robot.name} --skin-source host"
            )
        turned = [_z_becomes(np.asarray(model.joint_axes).reshape(-1, 3)[joint]) for joint in joints]
        places = np.asarray(model.parent_from_joint).reshape(-1, 4, 4)
        before = [np.eye(4), *turned[:-1]]
        prismatic = np.array([model.joint_kinds[joint] == JointKind.prismatic for joint in joints])
        reach = np.maximum(np.abs(robot.lower[joints]), np.abs(robot.upper[joints]))[
            prismatic & ~_first_slides(prismatic)
        ]
        return cls(
            link=link,
            joints=tuple(joints),
            before_from_joint=np.stack([before[k].T @ places[joint] @ turned[k] for k, joint in enumerate(joints)]),
            joint_from_link=turned[-1].T @ np.asarray(model.joint_from_link).reshape(-1, 4, 4)[index],
            prismatic=prismatic,
            slide_m=float(reach.max(initial=0.0)),
        )

    def codes(self, q: ArrayLike) -> list[int]:
        """(n,) the joint positions of this chain as they are broadcast, from those (m,) of the robot, rad or m."""
        value = np.where(_first_slides(self.prismatic), 0.0, np.asarray(q, dtype=float)[list(self.joints)])
        turns = np.rint(value / (2 * np.pi) * firmware.TURN).astype(int)
        slides = np.rint(value * 2.0**firmware.LENGTH_BITS).astype(int)
        wrapped = (turns + firmware.TURN // 2) % firmware.TURN - firmware.TURN // 2
        return [int(code) for code in np.where(self.prismatic, np.clip(slides, -32768, 32767), wrapped)]

    @property
    def code_kinds(self) -> list[tuple[int, str]]:
        """(n,) joint of the robot and how its position is told: "t" turns, "s" slides, "n" not needed."""
        unneeded = _first_slides(self.prismatic)
        kinds = np.where(unneeded, "n", np.where(self.prismatic, "s", "t"))
        return [(joint, str(kind)) for joint, kind in zip(self.joints, kinds, strict=True)]

    def of_cell(self, link_from_cell: ArrayLike) -> firmware.Chain:
        """The chain of the cell at `link_from_cell` (4, 4), in the smallest unit of length that holds every posture.

        Raises ChainError for a reach that no unit holds.
        """
        joint_from_cell = self.joint_from_link @ np.asarray(link_from_cell, dtype=float)
        for exponent in range(firmware.LENGTH_EXPONENT_MIN, firmware.LENGTH_EXPONENT_MAX + 1):
            unit = 2.0**exponent
            lengths = np.vstack([self.before_from_joint[1:, :3, 3], joint_from_cell[:3, 3]]) / unit
            if np.abs(lengths).max() >= 1 - 2.0**-firmware.LENGTH_BITS or self.slide_m >= unit:
                continue
            chain = firmware.Chain(
                places=[
                    (
                        _integers(place[:3, :3], firmware.MATRIX_BITS),
                        _integers(place[:3, 3] / unit, firmware.LENGTH_BITS),
                    )
                    for place in self.before_from_joint[1:]
                ],
                prismatic=self.prismatic.tolist(),
                length_exponent=exponent,
                point=_integers(joint_from_cell[:3, 3] / unit, firmware.LENGTH_BITS),
                direction=_integers(-joint_from_cell[:3, 2], firmware.UNIT_BITS),
            )
            if chain.valid(round(self.slide_m / unit * 2**firmware.LENGTH_BITS)):
                return chain
        raise ChainError(
            f"a cell on {self.link}, below which joints slide by up to {self.slide_m} m, can be further from a joint "
            f"than the {LONGEST_M:.1f} m that a cell counts"
        )


def _first_slides(prismatic: NDArray[np.bool_]) -> NDArray[np.bool_]:
    """(n,) whether a joint slides and every one before it does."""
    return np.logical_and.accumulate(prismatic)


def _z_becomes(axis: NDArray[np.float64]) -> NDArray[np.float64]:
    """(4, 4) the smallest rotation that turns z into a unit axis (3,)."""
    pose = np.eye(4)
    cross, cosine = np.cross([0.0, 0.0, 1.0], axis), float(axis[2])
    sine = float(np.linalg.norm(cross))
    if sine > 1e-12:
        pose[:3, :3] = Rotation.from_rotvec(cross / sine * np.arctan2(sine, cosine)).as_matrix()
    elif cosine < 0:
        pose[:3, :3] = np.diag([1.0, -1.0, -1.0])
    return pose


def _integers(values: NDArray[np.float64], bits: int) -> list[int]:
    """Flat, times 2^bits, rounded; 1 itself where it does not fit becomes the largest number of 16 bits."""
    return [int(value) for value in np.clip(np.rint(values.ravel() * 2.0**bits), -32768, 32767)]
