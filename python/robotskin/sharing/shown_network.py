# SPDX-License-Identifier: Apache-2.0
"""A skin without a session, for Foxglove: robot and cells in a posture, and the network as it lives."""

from __future__ import annotations

import threading
import time
from collections.abc import Callable
from typing import Any, Protocol

import numpy as np
from numpy.typing import NDArray

from robotskin.layout import Layout
from robotskin.record import Frame
from robotskin.robots import Robot
from robotskin.sharing.foxglove_server import FoxgloveServer
from robotskin.skin import Health, SkinState

PERIOD_S = 0.1


class Reading(Protocol):
    """What is known of a living network. alive: (N,); parent_port: (N,) 1 to 4, 0 for none."""

    @property
    def alive(self) -> NDArray[Any]:
        """Has power and runs."""

    @property
    def parent_port(self) -> NDArray[Any]:
        """To the cell's parent."""


class ShownNetwork:
    """Serves a posture and a network until `close`; nothing is felt, so every measured value is NaN.

    Args:
        port: 0 takes a free one. posture: (n,) rad or m as of now. look: at the network as of now; None: there is none.
        tell: hears where it is served.
    """

    def __init__(
        self,
        robot: Robot,
        layout: Layout,
        port: int,
        posture: Callable[[], NDArray[np.float64]],
        look: Callable[[], Reading] | None,
        tell: Callable[[str], None] = lambda text: None,
    ) -> None:
        self.server = FoxgloveServer(robot, layout, port)
        tell(self.server.told)
        self._posture, self._look = posture, look
        self._state = SkinState(len(layout))
        self._closing = threading.Event()
        self._thread = threading.Thread(target=self._run, name="shown network", daemon=True)
        self._thread.start()

    def __enter__(self) -> ShownNetwork:
        return self

    def __exit__(self, *_: object) -> None:
        self.close()

    def close(self) -> None:
        """End the thread and the server."""
        self._closing.set()
        self._thread.join()
        self.server.close()

    def _run(self) -> None:
        none = np.empty(0)
        while not self._closing.wait(PERIOD_S):
            reading = None if self._look is None else self._look()
            dead = np.ones(len(self._state), bool) if reading is None else ~np.asarray(reading.alive, bool)
            # Alive, but without a sample: the values that nothing has measured are masked.
            self._state.health[:] = np.where(dead, int(Health.dead), int(Health.never_seen))
            position = np.array(self._posture(), dtype=float)
            zero = np.zeros_like(position)
            moment = Frame(time.monotonic_ns(), self._state, position, zero, zero, none, 0, 0, self._state.normal_force)
            self.server.show(moment, time.time_ns())
            if reading is not None:
                heard_ns = np.where(dead, 0, 1)
                self.server.tell_network({"parent_port": reading.parent_port, "heard_ns": heard_ns}, {}, time.time_ns())
