# SPDX-License-Identifier: Apache-2.0
"""A skin as Foxglove's own messages: point cloud, frames, joints, robot, forces as arrows, the network's health.

They go into a context of foxglove-sdk; what listens there, a server or a file, is not known here.
"""

from __future__ import annotations

import json
from collections.abc import Mapping
from typing import Any

import foxglove
import numpy as np
from foxglove import channels
from foxglove.messages import (
    ArrowPrimitive,
    Color,
    FrameTransform,
    FrameTransforms,
    JointState,
    JointStates,
    LinePrimitive,
    LinePrimitiveLineType,
    PackedElementField,
    PackedElementFieldNumericType,
    Point3,
    PointCloud,
    Pose,
    Quaternion,
    SceneEntity,
    SceneUpdate,
    Timestamp,
    Vector3,
)
from numpy.typing import NDArray
from scipy.spatial.transform import Rotation

from robotskin.layout import Layout
from robotskin.layout.grown_tree import grown_tree
from robotskin.record import Frame
from robotskin.record.summary import TOUCH_N
from robotskin.robots import Robot
from robotskin.sharing.contacts import contacts
from robotskin.sharing.points import FIELDS, points
from robotskin.sharing.poses import Floats, PosedSkin
from robotskin.skin import Health

METRES_PER_N = 0.01
"""How long the arrow of a force is."""
ARROW_M = 0.006
FORCE_COLOUR = Color(r=0.95, g=0.35, b=0.1, a=1.0)
TREE_COLOUR = Color(r=0.2, g=0.7, b=0.9, a=0.8)
STRING_SCHEMA = {"type": "object", "properties": {"data": {"type": "string"}}}
HERE = Pose(position=Vector3(), orientation=Quaternion(w=1.0))
EVERY_NS = 1_000_000_000
"""How often the robot's description is told anew, for those that come late."""


class FoxgloveScene:
    """Logs the moments of a skin of N cells on a robot; the channels belong to `context`."""

    def __init__(self, robot: Robot, layout: Layout, urdf: str, context: foxglove.Context) -> None:
        """`urdf`: of the robot, with mesh names that the viewer can fetch."""
        self.context = context
        self._skin = PosedSkin(robot, layout)
        self._robot, self._layout, self._urdf = robot, layout, urdf
        self._told_ns: int | None = None
        self._base_from_cell: Floats | None = None
        self._driver: dict[str, int] = {}
        self._fields = [
            PackedElementField(name=name, offset=4 * index, type=PackedElementFieldNumericType.Float32)
            for index, name in enumerate(FIELDS)
        ]
        self._cloud = channels.PointCloudChannel("/skin/points", context=context)
        self._frames = channels.FrameTransformsChannel("/tf", context=context)
        self._joints = channels.JointStatesChannel("/joint_states", context=context)
        self._forces = channels.SceneUpdateChannel("/skin/forces", context=context)
        self._tree = channels.SceneUpdateChannel("/skin/tree", context=context)
        self._health = foxglove.Channel("/skin/health", message_encoding="json", context=context)
        self._contacts = foxglove.Channel("/skin/contacts", message_encoding="json", context=context)
        self._description = foxglove.Channel(
            "/robot_description",
            schema=foxglove.Schema(name="std_msgs/String", encoding="jsonschema", data=_json(STRING_SCHEMA)),
            message_encoding="json",
            context=context,
        )

    def show(self, frame: Frame, stamp_ns: int) -> bool:
        """Log a moment as of `stamp_ns`, nanoseconds since 1970; False before the robot's first joint state."""
        if len(frame.position) != self._robot.joint_count or not np.isfinite(frame.position).all():
            return False
        poses = self._skin.at(frame.position)
        self._base_from_cell = poses.base_from_cell
        stamp = Timestamp(sec=stamp_ns // 10**9, nsec=stamp_ns % 10**9)
        rows = points(frame, poses.base_from_cell)
        self._cloud.log(
            PointCloud(
                timestamp=stamp, frame_id=self._skin.base, pose=HERE, point_stride=4 * len(FIELDS),
                fields=self._fields, data=rows.tobytes(),
            ),
            log_time=stamp_ns,
        )  # fmt: skip
        self._frames.log(self._transforms(poses.translation, poses.rotation, stamp), log_time=stamp_ns)
        self._joints.log(
            JointStates(
                timestamp=stamp,
                joints=[
                    JointState(name=name, position=position, velocity=velocity, effort=effort)
                    for name, position, velocity, effort in zip(
                        self._robot.joint_names, frame.position.tolist(), frame.velocity.tolist(),
                        frame.effort.tolist(), strict=True,
                    )
                ],
            ),
            log_time=stamp_ns,
        )  # fmt: skip
        self._forces.log(self._arrows(rows, stamp), log_time=stamp_ns)
        told = {
            one.link: {
                "force_n": float(np.linalg.norm(one.force)), "cells": one.cells, "position": one.position.tolist(),
                "normal": one.normal.tolist(), "force": one.force.tolist(), "torque": one.torque.tolist(),
            }
            for one in contacts(self._layout, frame.skin)
        }  # fmt: skip
        self._contacts.log({"links": told}, log_time=stamp_ns)
        if self._told_ns is None or stamp_ns >= self._told_ns + EVERY_NS:
            self._told_ns = stamp_ns
            self._description.log({"data": self._urdf}, log_time=stamp_ns)
            self._health.log(self._counts(frame), log_time=stamp_ns)
        return True

    def tell_network(self, topology: Mapping[str, Any], statistics: Mapping[str, int], stamp_ns: int) -> None:
        """Log the cells' trees as lines, and the driver's counts."""
        if self._base_from_cell is None:
            return
        parent = grown_tree(self._layout, topology)
        cells = np.flatnonzero(parent >= 0)
        place = self._base_from_cell[:, :3, 3]
        ends = np.stack([place[cells], place[parent[cells]]], axis=1).reshape(-1, 3)
        line = LinePrimitive(
            type=LinePrimitiveLineType.LineList, pose=HERE, thickness=1.5, scale_invariant=True, color=TREE_COLOUR,
            points=[Point3(x=x, y=y, z=z) for x, y, z in ends.tolist()],
        )  # fmt: skip
        stamp = Timestamp(sec=stamp_ns // 10**9, nsec=stamp_ns % 10**9)
        entity = SceneEntity(timestamp=stamp, frame_id=self._skin.base, id="trees", lines=[line])
        self._tree.log(SceneUpdate(entities=[entity]), log_time=stamp_ns)
        self._driver = dict(statistics)

    def tell_again(self) -> None:
        """A new listener came: the next moment carries the robot's description."""
        self._told_ns = None

    def _transforms(self, translation: Floats, rotation: Floats, stamp: Timestamp) -> FrameTransforms:
        rows = zip(self._skin.parents, self._skin.links, translation.tolist(), rotation.tolist(), strict=True)
        return FrameTransforms(
            transforms=[
                FrameTransform(
                    timestamp=stamp, parent_frame_id=parent, child_frame_id=link,
                    translation=Vector3(x=at[0], y=at[1], z=at[2]),
                    rotation=Quaternion(x=turn[0], y=turn[1], z=turn[2], w=turn[3]),
                )
                for parent, link, at, turn in rows
            ]
        )  # fmt: skip

    def _arrows(self, rows: NDArray[np.float32], stamp: Timestamp) -> SceneUpdate:
        """An arrow for each cell that is touched; it ends on the cell."""
        force = rows[:, FIELDS.index("force")]
        touched = np.flatnonzero(np.nan_to_num(force) > TOUCH_N)
        arrows = []
        if len(touched):
            normal = rows[touched, 3:6].astype(float)
            length = METRES_PER_N * force[touched].astype(float) + ARROW_M
            tail = rows[touched, 0:3] + normal * length[:, None]
            turns = _turns_to(-normal)
            for at, turn, whole in zip(tail.tolist(), turns.tolist(), length.tolist(), strict=True):
                pose = Pose(
                    position=Vector3(x=at[0], y=at[1], z=at[2]),
                    orientation=Quaternion(x=turn[0], y=turn[1], z=turn[2], w=turn[3]),
                )
                arrows.append(
                    ArrowPrimitive(
                        pose=pose, shaft_length=whole - ARROW_M, shaft_diameter=0.003, head_length=ARROW_M,
                        head_diameter=0.007, color=FORCE_COLOUR,
                    )
                )  # fmt: skip
        entity = SceneEntity(timestamp=stamp, frame_id=self._skin.base, id="forces", arrows=arrows)
        return SceneUpdate(entities=[entity])

    def _counts(self, frame: Frame) -> dict[str, Any]:
        health = np.bincount(np.asarray(frame.skin.health), minlength=len(Health))
        cells = {one.name: int(health[int(one)]) for one in Health}
        share = cells["alive"] / max(1, len(frame.skin))
        return {"cells": cells, "share_alive": share, "gaps": frame.gaps, "driver": self._driver}


def _turns_to(direction: Floats) -> Floats:
    """(K, 4) quaternions (x, y, z, w) that turn the x axis, along which arrows lie, to each direction (K, 3)."""
    helper = np.where(np.abs(direction[:, 2:3]) < 0.9, [[0.0, 0.0, 1.0]], [[0.0, 1.0, 0.0]])
    side = np.cross(helper, direction)
    side /= np.linalg.norm(side, axis=1, keepdims=True)
    return Rotation.from_matrix(np.stack([direction, side, np.cross(direction, side)], axis=2)).as_quat()


def _json(value: Any) -> bytes:
    return json.dumps(value).encode()
