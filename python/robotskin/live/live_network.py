# SPDX-License-Identifier: Apache-2.0
"""The cells' network of a skin, alive on a thread of its own and without a body, for a page that looks and meddles."""

from __future__ import annotations

import queue
import threading
import time
from collections.abc import Callable

from robotskin import simulator as core
from robotskin.keys import SkinKeys
from robotskin.layout import Layout
from robotskin.layout.cell_network import CellNetwork
from robotskin.live.network_watch import NetworkError, NetworkWatch
from robotskin.live.watched_network import WatchedNetwork

WALL_STEP_S = 1 / 60
WATCH_STEP_S = 0.0002
"""While cells are stranded time goes in steps this small: so exact is the time of a repair."""


class LiveNetwork(WatchedNetwork):
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
        options.seed = seed
        options.unasked = True
        options.set_cell_key(SkinKeys.of_seed(seed).cell_key)
        self._mailbox = core.InProcess()
        units = CellNetwork.of_layout(layout).unit_descriptions()
        self._world = core.World(None, layout.neighbours, layout.id.tolist(), units, options, self._mailbox)
        super().__init__(NetworkWatch(self._world.network, layout, lambda: self._world.time_ns * 1e-9))
        self._requests: queue.SimpleQueue[Callable[[], None]] = queue.SimpleQueue()
        self.failure: BaseException | None = None
        self._closing = threading.Event()
        self._thread = threading.Thread(target=self._run, name="network", daemon=True)
        self._thread.start()

    def __enter__(self) -> LiveNetwork:
        return self

    def __exit__(self, *_: object) -> None:
        self.close()

    def close(self) -> None:
        """End the thread."""
        self._closing.set()
        self._thread.join()

    # ---- What a page asks ----

    def set_pace(self, pace: float) -> None:
        """Seconds of the network for one of the wall clock, 0 to stand still."""
        if not 0.0 <= pace <= 1.0:
            raise NetworkError(f"pace {pace}: must be from 0 (paused) to 1 (real time)")
        self.pace = pace

    def _ask(self, request: Callable[[], None]) -> None:
        if self.failure is not None:
            raise NetworkError(f"the network has ended: {self.failure}")
        self._requests.put(request)

    # ---- On the network's thread ----

    def _run(self) -> None:
        try:
            due = time.monotonic()
            while not self._closing.wait(max(0.0, due - time.monotonic())):
                # A network slower than the wall clock is late, and does not catch up.
                due = max(due + WALL_STEP_S, time.monotonic())
                while not self._requests.empty():
                    self._requests.get()()
                    self.look()
                self._advance(self.pace * WALL_STEP_S)
        except BaseException as failure:
            self.failure = failure
            raise

    def _advance(self, seconds: float) -> None:
        end_ns = self._world.time_ns + round(seconds * 1e9)
        while self._world.time_ns < end_ns:
            left_ns = end_ns - self._world.time_ns
            self._world.run(min(left_ns, round(WATCH_STEP_S * 1e9)) if self._watch.broken else left_ns)
            self._mailbox.take()
            self.look()
