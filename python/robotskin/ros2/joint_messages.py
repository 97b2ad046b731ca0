# SPDX-License-Identifier: Apache-2.0
"""Joints as ros2_control tells and takes them: states by name, commands by order."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from robotskin.ros2.message_types import cdr, typestore
from robotskin.ros2.topic import Topic

Floats = NDArray[np.float64]
STATES = "sensor_msgs/msg/JointState"
COMMANDS = "std_msgs/msg/Float64MultiArray"


@dataclass(frozen=True)
class HeardJoints:
    """Of n joints: rad, rad/s and Nm (m, m/s, N); stamp_ns: the sender's, since 1970; 0: it told none."""

    position: Floats
    velocity: Floats
    effort: Floats
    stamp_ns: int


class JointOrder:
    """Takes joint states apart in the order of a robot's joints, whatever order they come in."""

    def __init__(self, names: Sequence[str]) -> None:
        self.names = tuple(names)
        self._as_told: tuple[str, ...] = ()
        self._rows: NDArray[np.intp] | None = None

    def heard(self, message: Any) -> HeardJoints | None:
        """A `sensor_msgs/JointState`; None where one of the joints is missing, named twice, or has no finite place."""
        told = tuple(message.name)
        if told != self._as_told:
            self._as_told, self._rows = told, self._order(told)
        if self._rows is None:
            return None
        position, velocity = self._column(message.position), self._column(message.velocity)
        if not (np.isfinite(position).all() and np.isfinite(velocity).all()):
            return None
        effort = self._column(message.effort)
        stamp = message.header.stamp
        told_ns = int(stamp.sec) * 1_000_000_000 + int(stamp.nanosec)
        return HeardJoints(position, velocity, np.where(np.isfinite(effort), effort, 0.0), told_ns)

    def _order(self, told: tuple[str, ...]) -> NDArray[np.intp] | None:
        if any(told.count(name) != 1 for name in self.names):
            return None
        return np.array([told.index(name) for name in self.names], dtype=np.intp)

    def _column(self, values: Any) -> Floats:
        """(n,) NaN where there is none for each name."""
        column = np.asarray(values, np.float64)
        if self._rows is None or len(column) != len(self._as_told):
            return np.full(len(self.names), np.nan)
        return column[self._rows]


def states_message(names: Sequence[str], position: Floats, velocity: Floats, effort: Floats, stamp_ns: int) -> Any:
    """A `sensor_msgs/JointState` of joints in the order of `names`; stamp_ns: since 1970."""
    types = typestore().types
    stamp = types["builtin_interfaces/msg/Time"](sec=stamp_ns // 10**9, nanosec=stamp_ns % 10**9)
    header = types["std_msgs/msg/Header"](stamp=stamp, frame_id="")
    return types[STATES](header=header, name=list(names), position=position, velocity=velocity, effort=effort)


def commands_bytes(topic: Topic, values: Floats) -> bytes:
    """A `std_msgs/Float64MultiArray` as a forward controller takes it: a value a joint, in the controller's order."""
    types = typestore().types
    layout = types["std_msgs/msg/MultiArrayLayout"](dim=[], data_offset=0)
    return cdr(topic, types[COMMANDS](layout=layout, data=np.ascontiguousarray(values, np.float64)))


def message_of(raw: bytes, type_name: str) -> Any | None:
    """What the bytes say; None where they are no message of that type."""
    try:
        return typestore().deserialize_cdr(raw, type_name)
    except Exception:  # whatever foreign bytes provoke in a parser
        return None
