# SPDX-License-Identifier: Apache-2.0
"""The message types of ROS 2 that a skin is told in: those of ROS, and those defined beside this file."""

from __future__ import annotations

from functools import cache
from pathlib import Path
from types import SimpleNamespace
from typing import Any

from rosbags.typesys import Stores, get_types_from_msg, get_typestore
from rosbags.typesys.store import Typestore

from robotskin.ros2.topic import Topic

PACKAGES = ("robotskin_msgs", "tactile_msgs")


@cache
def typestore() -> Typestore:
    """The types of ROS 2, Humble and later, and of `PACKAGES`."""
    store = get_typestore(Stores.ROS2_HUMBLE)
    for name, text in own_definitions().items():
        store.register(get_types_from_msg(text, name))
    return store


def own_definitions() -> dict[str, str]:
    """The definitions of `PACKAGES` by name, as .msg files have them."""
    folder = Path(__file__).parent
    return {
        f"{package}/msg/{path.stem}": path.read_text(encoding="utf-8")
        for package in PACKAGES
        for path in sorted((folder / package / "msg").glob("*.msg"))
    }


def short_names() -> SimpleNamespace:
    """The types by the last part of their names, to be made by keywords."""
    wanted = (
        "builtin_interfaces/msg/Time", "std_msgs/msg/Header", "std_msgs/msg/String", "sensor_msgs/msg/JointState",
        "sensor_msgs/msg/PointCloud2", "sensor_msgs/msg/PointField", "tf2_msgs/msg/TFMessage",
        "geometry_msgs/msg/TransformStamped", "geometry_msgs/msg/Transform", "geometry_msgs/msg/Vector3",
        "geometry_msgs/msg/Quaternion", "geometry_msgs/msg/Point", "geometry_msgs/msg/Wrench", *own_definitions(),
    )  # fmt: skip
    types = typestore().types
    return SimpleNamespace(**{name.rsplit("/", 1)[1]: types[name] for name in wanted})


def cdr(topic: Topic, message: Any) -> bytes:
    """A message as it goes over the wire and into bags."""
    return bytes(typestore().serialize_cdr(message, topic.type_name))
