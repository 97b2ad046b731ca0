# SPDX-License-Identifier: Apache-2.0
"""Where the joints behind a controller are: a client of RTDE, or of ROS 2, that receives and commands nothing."""

from __future__ import annotations

import socket
import struct
from typing import Protocol

import numpy as np
from numpy.typing import NDArray

from robotskin.rehearsal.franka_process import FrankaJointWatch
from robotskin.rehearsal.process import RehearsalError
from robotskin.robots import Robot
from robotskin.ur import RTDE_PORT

RETRY_STEPS = 200


class Watch(Protocol):
    """Looks at joints from outside."""

    def look(self) -> NDArray[np.float64]:
        """(n,) rad; the last ones known."""

    def close(self) -> None:
        """Look no more."""


def watched(controller: str, robot: Robot) -> Watch:
    """The joints behind a UR controller at an address, a rehearsed Franka (franka:ADDRESS), or in ROS 2 (ros2:DOMAIN).

    Raises RehearsalError if nothing tells them.
    """
    if controller.startswith("franka:"):
        return FrankaJointWatch(controller.removeprefix("franka:"))
    if not controller.startswith("ros2:"):
        return JointWatch(controller)
    try:
        from robotskin.rehearsal.ros2_joint_watch import Ros2JointWatch
    except ImportError as error:
        raise RehearsalError(f"{controller}: {error.name} is not installed: pip install 'robotskin[ros2]'") from error
    return Ros2JointWatch(int(controller.removeprefix("ros2:")), robot)


class JointWatch:
    """The newest joint positions of the controller at `host`; `look` never waits.

    Raises RehearsalError if nothing answers there at first; what is lost later is tried again.
    """

    def __init__(self, host: str, within_s: float = 5.0) -> None:
        self.host, self.position = host, np.zeros(6)
        self._connection = self._connect(within_s)
        self._came, self._retry = b"", 0

    def _connect(self, within_s: float) -> socket.socket:
        try:
            connection = socket.create_connection((self.host, RTDE_PORT), timeout=within_s)
            connection.settimeout(within_s)
            for kind, body in ((b"V", b"\x00\x02"), (b"O", struct.pack(">d", 125.0) + b"actual_q"), (b"S", b"")):
                connection.sendall(struct.pack(">H", len(body) + 3) + kind + body)
                size = struct.unpack(">H", _exactly(connection, 2))[0]
                _exactly(connection, size - 2)
            connection.settimeout(0.0)
        except OSError as error:
            raise RehearsalError(f"controller {self.host}: {error.strerror or error}") from None
        return connection

    def look(self) -> NDArray[np.float64]:
        """(6,) rad; the last ones known where the controller is silent."""
        try:
            while chunk := self._connection.recv(65536):
                self._came += chunk
            self._lost()
        except BlockingIOError:
            pass
        except OSError:
            self._lost()
        while len(self._came) >= 3:
            size = struct.unpack_from(">H", self._came)[0]
            if len(self._came) < size or size < 3:
                break
            if self._came[2:3] == b"U" and size == 3 + 1 + 48:
                self.position = np.array(struct.unpack_from(">6d", self._came, 4))
            self._came = self._came[size:]
        return self.position

    def _lost(self) -> None:
        self._retry += 1
        if self._retry % RETRY_STEPS:
            return
        self._connection.close()
        self._came = b""
        try:
            self._connection = self._connect(0.05)
        except RehearsalError:
            self._connection = socket.socket()  # answers with an error until the next try
            self._connection.settimeout(0.0)

    def close(self) -> None:
        """End the connection."""
        self._connection.close()


def _exactly(connection: socket.socket, count: int) -> bytes:
    found = b""
    while len(found) < count:
        chunk = connection.recv(count - len(found))
        if not chunk:
            raise ConnectionResetError
        found += chunk
    return found
