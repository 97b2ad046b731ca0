# SPDX-License-Identifier: Apache-2.0
"""The web server under a page: bound to this machine, for holders of its token alone, in the page's colours."""

import contextlib
import io
import re
import threading
from collections.abc import Iterator
from typing import Any

import viser
import websockets.asyncio.server

from robotskin.viewer.own_page import with_own_head
from robotskin.viewer.page_token import for_holders_only, fresh_token

HOST = "127.0.0.1"
OWN_ORIGIN = re.compile(r"http://(127\.0\.0\.1|localhost)(:\d+)?")
"""Whose WebSockets are taken; the port is the browser's, which another may stand in for (ssh -L)."""
PANEL_WIDTH = 288
_starting = threading.Lock()


class PageServer(viser.ViserServer):
    """A server whose page is opened by the address with this token alone."""

    token: str


def open_server(title: str, port: int, style: str = "") -> PageServer:
    """Serve an empty page; `port` is the first one tried, the next free one is used where it is taken.

    style: what its CSS has beyond that of all pages.
    """
    token = fresh_token()
    # The address is the caller's to print.
    with _for_own_pages_only(title, style, token), contextlib.redirect_stdout(io.StringIO()):
        server = PageServer(host=HOST, port=port, label=title, verbose=False)
    server.token = token
    server.gui.configure_theme(dark_mode=True, show_logo=False, show_share_button=False, brand_color=(64, 150, 220))
    server.gui.main_panel.dock_right()
    server.gui.main_panel.set_width(PANEL_WIDTH)
    return server


@contextlib.contextmanager
def _for_own_pages_only(title: str, style: str, token: str) -> Iterator[None]:
    """Servers that start in this block refuse what has no token, and WebSockets of other pages; they name their page.

    A browser lets any page of the web open a WebSocket to this machine and tells only its origin; viser asks for none.
    Programs other than browsers send no origin. Programs of other users of this machine have no token.
    """
    with _starting:
        serve = websockets.asyncio.server.serve

        def checked(*arguments: Any, process_request: Any = None, **options: Any) -> Any:
            answer = None if process_request is None else with_own_head(process_request, title, style)
            held = for_holders_only(answer, token)
            return serve(*arguments, origins=(OWN_ORIGIN, None), process_request=held, **options)

        websockets.asyncio.server.serve = checked  # type: ignore[assignment, misc]
        try:
            yield
        finally:
            websockets.asyncio.server.serve = serve  # type: ignore[misc]


def close_server(server: viser.ViserServer) -> None:
    """Stop serving."""
    with contextlib.redirect_stdout(io.StringIO()):
        server.stop()


def address(server: PageServer) -> str:
    """What to open in a browser; it is a secret, for it has the page's token."""
    return f"http://{HOST}:{server.get_port()}/?token={server.token}"
