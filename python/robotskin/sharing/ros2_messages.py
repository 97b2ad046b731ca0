# SPDX-License-Identifier: Apache-2.0
"""A moment of a skin as messages of ROS 2, for whatever carries them: a network, a bag."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy.spatial.transform import Rotation

from robotskin.layout import Layout
from robotskin.record import Frame
from robotskin.robots import Robot
from robotskin.ros2 import Topic
from robotskin.ros2.message_types import short_names
from robotskin.sharing.contacts import contacts
from robotskin.sharing.points import FIELDS, points
from robotskin.sharing.poses import PosedSkin, Poses
from robotskin.skin import SkinState

FLOAT32 = 7
"""`FLOAT32` of sensor_msgs/PointField."""


STATE = Topic("/skin/state", "robotskin_msgs/msg/SkinState")
JOINTS = Topic("/joint_states", "sensor_msgs/msg/JointState")
FRAMES = Topic("/tf", "tf2_msgs/msg/TFMessage")
POINTS = Topic("/skin/points", "sensor_msgs/msg/PointCloud2")
CONTACTS = Topic("/skin/contacts", "tactile_msgs/msg/TactileContacts")
LAYOUT = Topic("/skin/layout", "robotskin_msgs/msg/SkinLayout", latched=True)
DESCRIPTION = Topic("/robot_description", "std_msgs/msg/String", latched=True)
TOPICS = (STATE, JOINTS, FRAMES, POINTS, CONTACTS, LAYOUT, DESCRIPTION)


class Ros2Messages:
    """Makes the messages of a skin of N cells on a robot."""

    def __init__(self, robot: Robot, layout: Layout) -> None:
        self._robot, self._layout = robot, layout
        self._skin = PosedSkin(robot, layout)
        self._of = of = short_names()
        self._names = list(robot.joint_names)
        self._fields = [
            of.PointField(name=name, offset=4 * index, datatype=FLOAT32, count=1) for index, name in enumerate(FIELDS)
        ]

    def at_each_moment(self, frame: Frame, stamp_ns: int) -> Iterator[tuple[Topic, Any]]:
        """(topic, message) of what others may close a loop on: the whole skin, packed, and the joints."""
        yield STATE, self._state(frame, stamp_ns)
        if self.has_joints(frame):
            header = self._header(stamp_ns, "")
            effort = np.asarray(frame.effort)
            yield JOINTS, self._of.JointState(
                header=header, name=self._names, position=np.asarray(frame.position),
                velocity=np.asarray(frame.velocity), effort=effort,
            )  # fmt: skip

    def now_and_then(self, frame: Frame, stamp_ns: int) -> Iterator[tuple[Topic, Any]]:
        """(topic, message) of what is looked at: frames, point cloud, contacts of links."""
        yield CONTACTS, self._contacts(frame, stamp_ns)
        if self.has_joints(frame):
            poses = self._skin.at(frame.position)
            yield FRAMES, self._frames(poses, stamp_ns)
            yield POINTS, self._cloud(frame, poses, stamp_ns)

    def once(self, stamp_ns: int) -> Iterator[tuple[Topic, Any]]:
        """(topic, message) of what does not change: layout and robot."""
        layout = self._layout
        rotation = Rotation.from_matrix(layout.link_from_cell[:, :3, :3]).as_quat()
        yield (
            LAYOUT,
            self._of.SkinLayout(
                header=self._header(stamp_ns, self._skin.base),
                robot=layout.robot,
                links=list(layout.links),
                key=layout.keys.astype(np.uint32),
                link=layout.link.astype(np.uint32),
                link_from_cell=np.hstack([layout.link_from_cell[:, :3, 3], rotation]).astype(np.float32).ravel(),
                neighbours=np.ascontiguousarray(layout.neighbours[:, :, 0], np.int32).ravel(),
            ),
        )
        yield DESCRIPTION, self._of.String(data=self._robot.urdf)

    def has_joints(self, frame: Frame) -> bool:
        """Whether the robot's first joint state had come."""
        return len(frame.position) == self._robot.joint_count and bool(np.isfinite(frame.position).all())

    def _header(self, stamp_ns: int, frame_id: str) -> Any:
        stamp = self._of.Time(sec=stamp_ns // 10**9, nanosec=stamp_ns % 10**9)
        return self._of.Header(stamp=stamp, frame_id=frame_id)

    def _state(self, frame: Frame, stamp_ns: int) -> Any:
        skin = frame.skin
        sampled_ns = np.asarray(skin.stamp_ns)
        age = np.where(sampled_ns > 0, (frame.time_ns - sampled_ns) * 1e-9, np.inf)
        return self._of.SkinState(
            header=self._header(stamp_ns, self._skin.base),
            normal_force=_felt(skin, "force", skin.normal_force),
            proximity=_felt(skin, "proximity", skin.proximity),
            distance=_felt(skin, "proximity", skin.distance),
            acceleration=_felt(skin, "acceleration", skin.acceleration),
            temperature=_felt(skin, "temperature", skin.temperature),
            age=age.astype(np.float32),
            health=np.asarray(skin.health),
        )

    def _frames(self, poses: Poses, stamp_ns: int) -> Any:
        of = self._of
        rows = zip(
            self._skin.parents, self._skin.links, poses.translation.tolist(), poses.rotation.tolist(), strict=True
        )
        return of.TFMessage(
            transforms=[
                of.TransformStamped(
                    header=self._header(stamp_ns, parent), child_frame_id=link,
                    transform=of.Transform(
                        translation=of.Vector3(*at), rotation=of.Quaternion(*turn),
                    ),
                )
                for parent, link, at, turn in rows
            ]
        )  # fmt: skip

    def _cloud(self, frame: Frame, poses: Poses, stamp_ns: int) -> Any:
        rows = points(frame, poses.base_from_cell)
        return self._of.PointCloud2(
            header=self._header(stamp_ns, self._skin.base), height=1, width=len(rows), fields=self._fields,
            is_bigendian=False, point_step=4 * len(FIELDS), row_step=rows.nbytes, data=rows.view(np.uint8).ravel(),
            is_dense=False,
        )  # fmt: skip

    def _contacts(self, frame: Frame, stamp_ns: int) -> Any:
        of = self._of
        return of.TactileContacts(
            contacts=[
                of.TactileContact(
                    header=self._header(stamp_ns, one.link), name=one.link, position=of.Point(*one.position.tolist()),
                    normal=of.Vector3(*one.normal.tolist()),
                    wrench=of.Wrench(
                        force=of.Vector3(*one.force.tolist()), torque=of.Vector3(*one.torque.tolist())
                    ),
                )
                for one in contacts(self._layout, frame.skin)
            ]
        )  # fmt: skip


def _felt(skin: SkinState, sensor: str, values: Any) -> NDArray[np.float32]:
    """Flat; empty where the skin has no such sensor."""
    return np.asarray(values, np.float32).ravel() if sensor in skin.sensors else np.empty(0, np.float32)
