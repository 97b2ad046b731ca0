# SPDX-License-Identifier: Apache-2.0
"""What every page is: a server in the browser's reach, and one thread that draws on it, until `close`."""

from __future__ import annotations

import threading
from collections.abc import Callable
from typing import Self

import viser
from rich.console import Console

from robotskin.errors import RobotskinError
from robotskin.viewer.server import address, close_server, open_server


class ServedPage:
    """Serves at `address` from construction to `close`; what it draws starts with `_start`.

    `port` is the first one tried; where it is taken the next free one is used, so read `address`.
    """

    def __init__(self, title: str, port: int, style: str = "") -> None:
        self.server = open_server(title, port, style)
        self.address = address(self.server)
        self.failure: BaseException | None = None
        """What ended the drawing, where it ended by itself."""
        self._closing = threading.Event()

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *_: object) -> None:
        self.close()

    def _start(self, name: str) -> None:
        self._thread = threading.Thread(target=self._draw_on, name=name, daemon=True)
        self._thread.start()

    def _draw_on(self) -> None:
        try:
            self._run()
        except BaseException as failure:
            self.failure = failure
            # A picture that stands still looks like a robot that does: pages that are open, and later ones, say so.
            self.server.on_client_connect(self._tell_stopped)
            raise

    def _tell_stopped(self, client: viser.ClientHandle) -> None:
        told = str(self.failure) or type(self.failure).__name__
        body = f"{told}. What it shows is old. End the program with Ctrl-C, and start it again."
        client.add_notification("This page has stopped", body, color="red")

    def _run(self) -> None:
        """On the page's thread, until `_closing` is set."""
        raise NotImplementedError

    def close(self) -> None:
        """End the thread and stop serving; what the page shows goes on."""
        self._closing.set()
        self._thread.join()
        close_server(self.server)

    def serve(self, console: Console, at_end: str, hint: str = "") -> None:
        """Print the address and what a person may do, wait for Ctrl-C, and print what happens then."""
        console.print(f"open [bold]{self.address}[/]{hint} (Ctrl-C ends)", markup=True)
        try:
            threading.Event().wait()
        except KeyboardInterrupt:
            console.print(at_end)

    def command(self, action: Callable[[], None]) -> None:
        """Do what a person asks for; what is refused appears as a notice in every browser."""
        try:
            action()
        except RobotskinError as error:
            for client in self.server.get_clients().values():
                client.add_notification("Refused", str(error), color="red", auto_close_seconds=8.0)
