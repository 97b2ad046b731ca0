# SPDX-License-Identifier: Apache-2.0
"""The web server under a page: bound to this machine, in the page's colours."""

import contextlib
import io
import re
import threading
from collections.abc import Iterator
from typing import Any

import viser
import websockets.asyncio.server

from robotskin.viewer.own_page import with_own_head

HOST = "127.0.0.1"
OWN_ORIGIN = re.compile(r"http://(127\.0\.0\.1|localhost)(:\d+)?")
"""Whose WebSockets are taken; the port is the browser's, which another may stand in for (ssh -L)."""
PANEL_WIDTH = 288
_starting = threading.Lock()


def open_server(title: str, port: int, style: str = "") -> viser.ViserServer:
    """Serve an empty page; `port` is the first one tried, the next free one is used where it is taken.

    style: what its CSS has beyond that of all pages.
    """
    # The address is the caller's to print.
    with _for_own_pages_only(title, style), contextlib.redirect_stdout(io.StringIO()):
        server = viser.ViserServer(host=HOST, port=port, label=title, verbose=False)
    server.gui.configure_theme(dark_mode=True, show_logo=False, show_share_button=False, brand_color=(64, 150, 220))
    server.gui.main_panel.dock_right()
    server.gui.main_panel.set_width(PANEL_WIDTH)
    return server


@contextlib.contextmanager
def _for_own_pages_only(title: str, style: str) -> Iterator[None]:
    """Servers that start in this block refuse WebSockets of pages that this machine did not serve, and name their page.

    A browser lets any page of the web open a WebSocket to this machine and tells only its origin; viser asks for none.
    Programs other than browsers send no origin.
    """
    with _starting:
        serve = websockets.asyncio.server.serve

        def checked(*arguments: Any, process_request: Any = None, **options: Any) -> Any:
            answer = None if process_request is None else with_own_head(process_request, title, style)
            return serve(*arguments, origins=(OWN_ORIGIN, None), process_request=answer, **options)

        websockets.asyncio.server.serve = checked  # type: ignore[assignment, misc]
        try:
            yield
        finally:
            websockets.asyncio.server.serve = serve  # type: ignore[misc]


def close_server(server: viser.ViserServer) -> None:
    """Stop serving."""
    with contextlib.redirect_stdout(io.StringIO()):
        server.stop()


def address(server: viser.ViserServer) -> str:
    """What to type into a browser."""
    return f"http://{HOST}:{server.get_port()}"
