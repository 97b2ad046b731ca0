# SPDX-License-Identifier: Apache-2.0
"""The cells' network of a skin, alive on a thread of its own and without a body, for a page that looks and meddles."""

from __future__ import annotations

import time
from pathlib import Path

from robotskin import simulator as core
from robotskin.keys import SkinKeys
from robotskin.layout import Layout
from robotskin.layout.cell_network import CellNetwork
from robotskin.live.network_host import NetworkHost
from robotskin.live.network_watch import NetworkError, NetworkWatch
from robotskin.live.own_thread import OwnThread
from robotskin.live.watched_network import WatchedNetwork
from robotskin.robots import Robot
from robotskin.world.ideal import default_processor

WALL_STEP_S = 1 / 60
WATCH_STEP_S = 0.0002
"""While cells are stranded time goes in steps this small: so exact is the time of a repair."""


class LiveNetwork(OwnThread, WatchedNetwork):
    """Runs the shipping firmware in N cells and their section units until `close`.

    It is a `robotskin.viewer.network_view.NetworkView`: every method may be called from any thread and returns at once.

    Args:
        layout: the skin; it needs at least one cable.
        seed: of wires and clocks. What a person does comes when it comes, so only an untouched run repeats.
        pace: seconds of the network for one of the wall clock.
    """

    paced = True

    def __init__(self, layout: Layout, seed: int = 1, pace: float = 0.1) -> None:
        if not layout.section_unit_ports:
            raise NetworkError("a skin without cables has no network: its layout names no section-unit ports")
        self.layout = layout
        self.pace = pace
        options = core.NetworkOptions()
        options.processor = default_processor()
        options.seed = seed
        options.unasked = True
        options.set_cell_key(SkinKeys.of_seed(seed).cell_key)
        self._mailbox = core.InProcess()
        units = CellNetwork.of_layout(layout).unit_descriptions()
        self._world = core.World(None, layout.neighbours, layout.id.tolist(), units, options, self._mailbox)
        OwnThread.__init__(self, "network", NetworkError, daemon=True)
        watch = NetworkWatch(self._world.network, layout, lambda: self._world.time_ns * 1e-9)
        WatchedNetwork.__init__(self, watch)
        self._units, self._seed = units, seed
        self.host: NetworkHost | None = None
        """Hears and records it; None: the section units send to nothing."""
        self._begin()

    def close(self) -> None:
        """End the thread, and the recording where there is one. Raises RecordError if its file is not whole."""
        super().close()
        if self.host is not None:
            self.host.close()

    def record(self, robot: Robot, path: Path) -> None:
        """Record what a host hears, from now on until `close`. Raises RecordError where the file cannot be written."""
        self.host = NetworkHost(robot, self.layout, self._units, self._mailbox, self._seed, path)

    # ---- What a page asks ----

    def set_pace(self, pace: float) -> None:
        """Seconds of the network for one of the wall clock, 0 to stand still."""
        if not 0.0 <= pace <= 1.0:
            raise NetworkError(f"pace {pace}: must be from 0 (paused) to 1 (real time)")
        self.pace = pace

    # ---- On the network's thread ----

    def _work(self) -> None:
        due = time.monotonic()
        while not self._closing.wait(max(0.0, due - time.monotonic())):
            # A network slower than the wall clock is late, and does not catch up.
            due = max(due + WALL_STEP_S, time.monotonic())
            while self._obey():
                self.look()
            self._advance(self.pace * WALL_STEP_S)

    def _advance(self, seconds: float) -> None:
        end_ns = self._world.time_ns + round(seconds * 1e9)
        while self._world.time_ns < end_ns:
            left_ns = end_ns - self._world.time_ns
            self._world.run(min(left_ns, round(WATCH_STEP_S * 1e9)) if self._watch.broken else left_ns)
            if self.host is None:
                self._mailbox.take()
            else:
                self.host.exchange(self._world.time_ns)
            self.look()

    def _tell(self, change: str) -> None:
        if self.host is not None:
            self.host.recorder.note(change)
