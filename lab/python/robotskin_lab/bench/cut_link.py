# SPDX-License-Identifier: Apache-2.0
"""A TCP link that can be broken: a relay between a member of a fleet and its router."""

from __future__ import annotations

import contextlib
import socket
import threading

PIECE = 1 << 16
LOOK_S = 0.01


class CutLink:
    """Relays `port` on 127.0.0.1 to another port there, until `close`.

    `cut` ends all connections and refuses new ones; `swallow` keeps them open, but nothing goes through; `mend` ends
    either.
    """

    def __init__(self, to_port: int) -> None:
        self._to_port = to_port
        self._listener = socket.create_server(("127.0.0.1", 0))
        self.port: int = self._listener.getsockname()[1]
        self._flows, self._refuses, self._closing = threading.Event(), False, False
        self._flows.set()
        self._ends: list[socket.socket] = []
        self._lock = threading.Lock()
        threading.Thread(target=self._accept, name="cut link", daemon=True).start()

    def cut(self) -> None:
        """As if the cable was pulled and both ends saw it."""
        self._refuses = True
        with self._lock:
            ends, self._ends = self._ends, []
        for one in ends:
            with contextlib.suppress(OSError):
                one.shutdown(socket.SHUT_RDWR)

    def swallow(self) -> None:
        """As if a radio was shadowed: no end is told."""
        self._flows.clear()

    def mend(self) -> None:
        """All is well again."""
        self._refuses = False
        self._flows.set()

    def close(self) -> None:
        """End."""
        self._closing = True
        self.cut()
        self._flows.set()
        with contextlib.suppress(OSError):
            self._listener.shutdown(socket.SHUT_RDWR)
        self._listener.close()

    def _accept(self) -> None:
        while not self._closing:
            try:
                near, _ = self._listener.accept()
                if self._refuses:
                    near.close()
                    continue
                far = socket.create_connection(("127.0.0.1", self._to_port))
            except OSError:
                continue
            with self._lock:
                self._ends += [near, far]
            for one, other in ((near, far), (far, near)):
                threading.Thread(target=self._relay, args=(one, other), daemon=True).start()

    def _relay(self, source: socket.socket, sink: socket.socket) -> None:
        with contextlib.suppress(OSError):
            while piece := source.recv(PIECE):
                self._flows.wait()
                sink.sendall(piece)
        for one in (source, sink):
            with contextlib.suppress(OSError):
                one.shutdown(socket.SHUT_RDWR)
            one.close()
