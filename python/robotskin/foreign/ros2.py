# SPDX-License-Identifier: Apache-2.0
"""Frames from topics of ROS 2, without ROS: `tactile_msgs/TactileState` and `sensor_msgs/PointCloud2`."""

from __future__ import annotations

import threading
import time
from collections.abc import Callable
from typing import Any

import numpy as np

from robotskin.foreign.declared import Declared, Source
from robotskin.foreign.errors import ForeignSkinError
from robotskin.foreign.frames import Counts, Tally
from robotskin.foreign.sources import Frames
from robotskin.ros2 import Topic
from robotskin.ros2.dds import DdsNode

TYPES = {"ros2_tactile": "tactile_msgs/msg/TactileState", "ros2_points": "sensor_msgs/msg/PointCloud2"}
POLL_S = 0.002
NUMBERS = {1: "i1", 2: "u1", 3: "i2", 4: "u2", 5: "i4", 6: "u4", 7: "f4", 8: "f8"}
"""Of `sensor_msgs/PointField`."""


def frames(source: Source, declared: Declared, tally: Tally, closing: threading.Event) -> Frames:
    """What comes on a topic. Raises ForeignSkinError for what is no name of one."""
    if not source.at.startswith("/"):
        raise ForeignSkinError(f"{source.at}: a topic of ROS 2 begins with /")
    node = DdsNode(source.domain, source.interface or None)
    reader = node.reader(Topic(source.at, TYPES[source.kind]))
    counts_of = tactile_counts if source.kind == "ros2_tactile" else point_counts
    return _heard(node, reader, source, declared, counts_of, tally, closing)


def _heard(
    node: DdsNode,
    reader: Any,
    source: Source,
    declared: Declared,
    counts_of: Callable[[Any, Source, Declared], Counts | None],
    tally: Tally,
    closing: threading.Event,
) -> Frames:
    while not closing.wait(POLL_S):
        for message in reader.take(N=10):
            counts = counts_of(message, source, declared)
            if counts is None:
                tally.bad += 1
                continue
            tally.frames += 1
            yield stamp_of(message.header.stamp), counts


def stamp_of(stamp: Any) -> int:
    """The host time of a message: its own stamp, of the system's clock; now where it has none."""
    now_ns = time.monotonic_ns()
    told_ns = int(stamp.sec) * 1_000_000_000 + int(stamp.nanosec)
    return now_ns if told_ns == 0 else now_ns - (time.time_ns() - told_ns)


def tactile_counts(message: Any, source: Source, declared: Declared) -> Counts | None:
    """The values of all sensors of a `TactileState`, in its order; None for another count than declared."""
    width = declared.values
    values = np.concatenate([np.asarray(one.values, np.float64) for one in message.sensors] or [np.empty(0)])
    return values.reshape(-1, width) if values.size == source.slots * width else None


def point_counts(message: Any, source: Source, declared: Declared) -> Counts | None:
    """The declared fields of each point of a `PointCloud2`, a point a slot; None for a cloud that does not fit."""
    fields = {str(one.name): one for one in message.fields}
    points, step = int(message.width) * int(message.height), int(message.point_step)
    data = bytes(message.data)
    rows = message.height == 1 or int(message.row_step) == step * int(message.width)
    if points != source.slots or step <= 0 or len(data) < points * step or not rows:
        return None
    table = np.frombuffer(data, np.uint8, points * step).reshape(points, step)
    columns = []
    for channel in declared.channels:
        one = fields.get(channel.field or channel.sensor)
        kind = NUMBERS.get(int(one.datatype)) if one is not None else None
        if one is None or kind is None:
            return None
        number = np.dtype((">" if message.is_bigendian else "<") + kind)
        at, size = int(one.offset), number.itemsize * channel.values
        if max(int(one.count), 1) < channel.values or at + size > step:
            return None
        columns.append(np.ascontiguousarray(table[:, at : at + size]).view(number).astype(np.float64))
    return np.concatenate(columns, axis=1)
