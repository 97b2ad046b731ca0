# SPDX-License-Identifier: Apache-2.0
"""The four fingers of the Allegro hand: where their pads are, and which cells feel what they hold."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from robotskin.firmware import FORCE_SENSOR_POINTS_M, HEXAGON_SIDE_M
from robotskin.layout import Layout
from robotskin.model import RobotDynamics
from robotskin.robots import Robot
from robotskin.robots.limbs import limbs_of
from robotskin.session import SessionError

Array = NDArray[np.float64]

LIFT, ARM = "lift", "arm"
"""What carries the hand: the joint of a carriage, or the limb of an arm."""
FITS = ("allegro_grasp", "ur5_allegro")
PALM = "palm_link"
PALM_FROM_HAND = np.array([[1.0, 0, 0, 0], [0, 0, 1, 0], [0, -1, 0, 0], [0, 0, 0, 1]])
"""The frame in which a grasp is planned: at the palm's, z up as one holds a glass, x where the palm looks."""
FINGERS = {"index": (0, 1, 2, 3), "middle": (4, 5, 6, 7), "ring": (8, 9, 10, 11), "thumb": (12, 13, 14, 15)}
"""Numbers of each finger's joints and links, the same in their names."""
NAMES = tuple(FINGERS)
THUMB = NAMES.index("thumb")
_PALMAR = 0.4
"""Least part of a cell's normal along the palm's side of its link."""


def carrier_joints(robot: Robot) -> NDArray[np.int64]:
    """The indices of a carriage's joint, or of an arm's. Raises SessionError where there is neither."""
    if LIFT in robot.joint_names:
        return np.array([robot.joint_index(LIFT)])
    joints = [one for limb in limbs_of(robot.core) if limb.name == ARM for one in limb.joints]
    if not joints:
        raise SessionError(
            f"grasp with {robot.name}: it has no joint {LIFT} and no limb {ARM}; use {' or '.join(FITS)}"
        )
    return np.array([robot.joint_index(one) for one in joints])


def base_from_hand(robot: Robot, posture: Array) -> Array:
    """(4, 4) where the hand's frame is for (n) rad or m. Raises UnknownNameError for a robot without a palm."""
    return np.asarray(robot.base_from_link(posture)[robot.link_index(PALM)] @ PALM_FROM_HAND)


@dataclass(frozen=True)
class Pads:
    """The pads of four fingers. place: (4, 3) metres; normal: (4, 3); in the hand's frame (`PALM_FROM_HAND`).

    axes: (4, 3, 3) of the pads' cells; moves: (4, 3, 4) metres per radian and turns: (4, 3, 4) of the normal, by the
    finger's four joints.
    """

    place: Array
    normal: Array
    axes: Array
    moves: Array
    turns: Array

    def touched(self, readings: Array) -> Array:
        """(4, 3) metres where the pads are pressed, from the (4, 3) forces of their cells' sensors."""
        share = readings / np.maximum(readings.sum(axis=1, keepdims=True), 1e-9)
        points = np.asarray(FORCE_SENSOR_POINTS_M)
        towards = points / np.linalg.norm(points, axis=1, keepdims=True)
        aside = 2 * HEXAGON_SIDE_M * share @ towards
        return np.asarray(self.place + np.einsum("fij,fj->fi", self.axes[:, :, :2], aside))


class Hand:
    """The hand of a robot in its skin.

    Raises:
        SessionError: a robot that lacks a finger's joint, or a finger tip without a cell on its front.
    """

    def __init__(self, robot: Robot, layout: Layout) -> None:
        wanted = [f"joint_{number}.0" for numbers in FINGERS.values() for number in numbers]
        missing = [name for name in wanted if name not in robot.joint_names]
        if missing:
            raise SessionError(f"grasp with {robot.name}: it has no joint {missing[0]}; use {' or '.join(FITS)}")
        self.robot = robot
        self.carrier = carrier_joints(robot)
        """(k,) indices of the joints that carry the hand."""
        self.joints = np.array(
            [[robot.joint_index(f"joint_{one}.0") for one in numbers] for numbers in FINGERS.values()]
        )
        """(4, 4) indices of the fingers' joints."""
        self.lower, self.upper = robot.lower[self.joints], robot.upper[self.joints]
        self.front: list[NDArray[np.int64]] = []
        """Of each finger, its cells that touch what it holds."""
        self.back: list[NDArray[np.int64]] = []
        """Of each finger, its cells on the other side."""
        self.outside: list[NDArray[np.int64]] = []
        """Of each finger, all cells but those of its front: what touches them is not what it holds."""
        self.tip = np.zeros(4, dtype=int)
        """(4,) the cell of each finger's pad."""
        for finger, numbers in enumerate(FINGERS.values()):
            links = [f"link_{number}.0" for number in numbers] + [f"link_{numbers[3]}.0_tip"]
            on = np.array([cell for cell, link in enumerate(layout.link) if layout.links[link] in links], dtype=int)
            out = layout.link_from_cell[on, 0, 2] if len(on) else np.zeros(0)
            self.front.append(on[out > _PALMAR])
            self.back.append(on[out < -_PALMAR])
            self.outside.append(on[out <= _PALMAR])
            tips = [cell for cell in self.front[-1] if layout.links[layout.link[cell]] == links[-1]]
            if not tips:
                raise SessionError(
                    f"grasp with this layout of {layout.robot}: the {NAMES[finger]} finger has no cell on the front of "
                    f"{links[-1]}; use the layout that comes with {' or '.join(FITS)}"
                )
            self.tip[finger] = tips[0]
        self._layout = layout
        dynamics = RobotDynamics(robot.core)
        zero = np.zeros(robot.joint_count)
        dynamics.update(zero, zero)
        motion = np.asarray(dynamics.joint_motions)[self.joints]
        self._axis = motion[..., 3:]
        # A point of each axis, the nearest to the origin: of the velocity v at the origin and the turn w, w x v.
        hand_from_base = np.linalg.inv(base_from_hand(robot, zero))
        self._point = np.cross(self._axis, motion[..., :3]) @ hand_from_base[:3, :3].T + hand_from_base[:3, 3]
        self._axis = self._axis @ hand_from_base[:3, :3].T
        cross = np.zeros((4, 4, 3, 3))
        for row, column, axis, sign in ((0, 1, 2, -1), (0, 2, 1, 1), (1, 2, 0, -1)):
            cross[..., row, column] = sign * self._axis[..., axis]
            cross[..., column, row] = -sign * self._axis[..., axis]
        self._cross, self._twice = cross, cross @ cross
        base_from_link = robot.base_from_link(zero)
        pads = [
            hand_from_base
            @ base_from_link[robot.link_index(layout.links[layout.link[cell]])]
            @ layout.link_from_cell[cell]
            for cell in self.tip
        ]
        self._pad = np.array(pads)

    def frames(self, posture: Array, cells: NDArray[np.int64]) -> Array:
        """(c, 4, 4) of (c) cells in the hand's frame, for (n) rad or m of the robot's joints."""
        links = [self.robot.link_index(self._layout.links[one]) for one in self._layout.link[cells]]
        base_from_link = self.robot.base_from_link(posture)
        hand_from_base = np.linalg.inv(base_from_link[self.robot.link_index(PALM)] @ PALM_FROM_HAND)
        return np.asarray(hand_from_base @ base_from_link[links] @ self._layout.link_from_cell[cells])

    def pads(self, angles: Array) -> Pads:
        """Where the pads are for (4, 4) rad, a row a finger."""
        sine, rest = np.sin(angles)[..., None, None], 1 - np.cos(angles)[..., None, None]
        turn = np.eye(3) + sine * self._cross + rest * self._twice
        # About a point c of the axis: x -> R x + c - R c.
        moved = self._point - (turn @ self._point[..., None])[..., 0]
        # Of each joint: its turn, the shift that comes with it, its axis, and a point of this.
        own = np.concatenate([turn, np.stack([moved, self._axis, self._point], axis=-1)], axis=-1)
        rotation, shift = np.broadcast_to(np.eye(3), (4, 3, 3)), np.zeros((4, 3))
        axes, points = [], []
        for joint in range(4):
            placed = rotation @ own[:, joint]
            axes.append(placed[..., 4])
            points.append(placed[..., 5] + shift)
            rotation, shift = placed[..., :3], shift + placed[..., 3]
        pad = rotation @ self._pad[:, :3]
        place, pad_axes = pad[..., 3] + shift, pad[..., :3]
        normal = pad_axes[..., 2]
        every_axis = np.stack(axes)
        moves = np.moveaxis(np.cross(every_axis, place - np.stack(points)), 0, 2)
        turns = np.moveaxis(np.cross(every_axis, normal[None]), 0, 2)
        return Pads(place, normal, pad_axes, moves, turns)
