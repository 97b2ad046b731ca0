# SPDX-License-Identifier: Apache-2.0
"""A Franka that is not there, in a process of its own: the project franky-sim serves the vendor's protocol on MuJoCo.

Only one client of that protocol may be there, so this process tells the joints beside it to those that watch.
"""

from __future__ import annotations

import contextlib
import importlib
import socket
import time
from collections.abc import Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from robotskin.rehearsal.process import Process, RehearsalError
from robotskin.robots.gains import robot_with_gains

STEP_S, BEHIND_S = 0.001, 0.5
JOINTS = 7
WATCH_PORT = 1338
STIFFNESS = (22500.0, 22500.0, 17500.0, 17500.0, 2500.0, 2500.0, 2500.0)
DAMPING = (450.0, 450.0, 350.0, 350.0, 50.0, 50.0, 50.0)
"""Nm/rad and Nm s/rad of its servos: as fast as those of the real one, five times as fast as franky-sim's own."""
LEAST = np.array([-2.7437, -1.7837, -2.9007, -3.0421, -2.8065, 0.5445, -3.0159])
MOST = np.array([2.7437, 1.7837, 2.9007, -0.1518, 2.8065, 4.5169, 3.0159])
"""rad that the joints of a Research 3 reach; joint 6 of a Panda reaches less far up and further down."""
SPARE = 0.1
"""rad to a joint's end at the start."""


class FrankaController:
    """Serves at `host` until `close`; `run` lets real time pass.

    Args:
        posture: (7,) rad where it starts; a joint that would stand at its end or beyond starts a little within, for
            one beyond is thrown back while nothing commands it. host: an address of this machine.

    Raises RehearsalError: franky-sim is not installed, or the address cannot be had.
    """

    def __init__(self, posture: Sequence[float], host: str) -> None:
        try:
            franky_sim = importlib.import_module("franky_sim")
            mujoco_simulator = importlib.import_module("franky_sim.mujoco_simulator")
        except ImportError as error:
            raise RehearsalError(f"{error.name} is not installed: pip install franky-sim") from None
        self._simulator = mujoco_simulator.MujocoSimulator()
        self._simulator.init()
        starts = np.clip(posture, LEAST + SPARE, MOST - SPARE)
        self.arm: Any = self._simulator.add_robot(initial_q=tuple(starts.tolist()), kp=STIFFNESS, kv=DAMPING)
        self._server = franky_sim.SimulationServer(self._simulator, [host])
        self._watchers = socket.socket(socket.AF_INET, socket.SOCK_DGRAM)
        self._watchers.setblocking(False)
        try:
            self._server.init()
            self._watchers.bind((host, WATCH_PORT))
        except OSError as error:
            raise RehearsalError(f"controller at {host}: {error}") from None
        self.steps = 0
        self._due = time.monotonic()

    @property
    def position(self) -> NDArray[np.float64]:
        """(7,) rad."""
        return np.array(self.arm.inner_state.q)

    @property
    def velocity(self) -> NDArray[np.float64]:
        """(7,) rad/s."""
        return np.array(self.arm.inner_state.dq)

    def run(self, seconds: float) -> None:
        """Let real time pass."""
        ends = time.monotonic() + seconds
        while (now := time.monotonic()) < ends:
            self._server.run_once(realtime=False)
            self.steps += 1
            self._tell_watchers()
            self._due = max(self._due + STEP_S, now - BEHIND_S)
            ahead = self._due - time.monotonic()
            if ahead > 0:
                time.sleep(ahead)

    def _tell_watchers(self) -> None:
        while True:
            try:
                _, watcher = self._watchers.recvfrom(16)
                self._watchers.sendto(self.position.tobytes(), watcher)
            except OSError:
                return

    def close(self) -> None:
        """End."""
        self._server.cleanup()
        self._simulator.cleanup()
        self._watchers.close()


def make(posture: Sequence[float], host: str) -> FrankaController:
    """In the process that shall run it."""
    return FrankaController(posture, host)


def franka_controller(robot: str = "panda", host: str = "127.0.0.1", posture: Sequence[float] | None = None) -> Process:
    """Start a Franka at an address of this machine. Raises RehearsalError if it cannot be had.

    Args:
        robot: by name or URDF, 7 joints, for the posture where it starts; by default the home of its gains.
        host: of this machine, such as 127.0.0.2.
        posture: (7,) rad.
    """
    at = robot_with_gains(robot).gains.home if posture is None else posture
    if len(at) != JOINTS:
        raise RehearsalError(f"a Franka has {JOINTS} joints: {robot} has {len(at)}; name panda, or the URDF of yours")
    return Process(make, posture=[float(one) for one in at], host=host)


class FrankaJointWatch:
    """The newest joint positions of the controller at `host`; `look` never waits.

    Raises RehearsalError if nothing answers there at first.
    """

    def __init__(self, host: str, within_s: float = 20.0) -> None:
        self._socket = socket.socket(socket.AF_INET, socket.SOCK_DGRAM)
        self._socket.connect((host, WATCH_PORT))
        self._socket.settimeout(0.1)
        self._position: NDArray[np.float64] | None = None
        ends = time.monotonic() + within_s
        while self._position is None:
            if time.monotonic() > ends:
                raise RehearsalError(f"controller {host}: no rehearsed Franka tells its joints there")
            self._ask()
            self._take()
        self._socket.setblocking(False)

    def _ask(self) -> None:
        try:
            self._socket.send(b"?")
        except OSError:
            time.sleep(0.001)

    def _take(self) -> None:
        with contextlib.suppress(OSError):
            self._position = np.frombuffer(self._socket.recv(256))

    def look(self) -> NDArray[np.float64]:
        """(7,) rad; the last ones known."""
        self._take()
        self._ask()
        assert self._position is not None
        return self._position

    def close(self) -> None:
        """Look no more."""
        self._socket.close()
