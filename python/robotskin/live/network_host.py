# SPDX-License-Identifier: Apache-2.0
"""A host for a network without a body: driver and skin reader hear what its section units send, so it is recorded."""

from __future__ import annotations

from pathlib import Path

from robotskin.driver import Driver
from robotskin.layout import Layout
from robotskin.record import Recorder
from robotskin.robots import Robot
from robotskin.simulator import InProcess, UnitDescription
from robotskin.skin import SkinReader, SkinState

__all__ = ["NetworkHost"]


class NetworkHost:
    """Hears N cells, of which nothing touches any, and records them into a new file until `close`.

    `exchange` is called by one thread; `close` once that has ended.

    Args:
        robot: that wears them. units: of the network; mailbox: through which they speak. seed: of the network.
        path: of the file.

    Raises:
        RecordError: the file exists or cannot be written.
    """

    loop = None
    """Nothing moves."""

    def __init__(
        self,
        robot: Robot,
        layout: Layout,
        units: list[UnitDescription],
        mailbox: InProcess,
        seed: int,
        path: Path,
    ) -> None:
        self.robot, self.layout, self.seed = robot, layout, seed
        self._units, self._mailbox = units, mailbox
        model = layout.skin_model()
        self.driver = Driver(model, None, session_seed=seed)
        self.reader = SkinReader(self.driver, model)
        self._state = SkinState(len(layout))
        self.recorder = Recorder(path, self)

    def exchange(self, now_ns: int) -> None:
        """Hear what has come, read the skin, and answer the section units."""
        for _, when_ns, datagram in self._mailbox.take():
            self.driver.handle(datagram, when_ns)
        self.driver.publish(now_ns)
        for group, unit, datagram in self.driver.downlink(now_ns):
            for index, description in enumerate(self._units):
                if description.group == group and unit in (description.unit, 255):
                    self._mailbox.post(index, datagram)
        self.reader.read(now_ns, self._state)

    def close(self) -> None:
        """End the file. Raises RecordError if it is not whole."""
        self.recorder.close()
