# SPDX-License-Identifier: Apache-2.0
"""A browser opens the page by the address with its token, and by nothing else until it was let in."""

from typing import TYPE_CHECKING

from browsing import free_port, opened, wait_for

from robotskin.viewer.server import address, close_server, open_server

if TYPE_CHECKING:
    from playwright import sync_api

SHOWN = "shown over the WebSocket"


def test_a_browser_needs_the_token_once(browser: "sync_api.Browser") -> None:
    server = open_server("a page", free_port())
    try:
        server.gui.add_markdown(SHOWN)
        bare = f"http://127.0.0.1:{server.get_port()}/"
        without_token = opened(browser, bare)
        assert "token" in without_token.inner_text("body")
        assert not server.get_clients()
        page = opened(browser, address(server))
        shown = page.get_by_text(SHOWN)
        wait_for(lambda: shown.count() > 0, "the page with the token shows nothing")
        page.goto(bare)  # its cookie lets it in from now on
        wait_for(lambda: shown.count() > 0, "the page is not let in by its cookie")
        assert page.evaluate("document.cookie") == ""  # no script reads it
        without_token.goto(bare)
        assert "token" in without_token.inner_text("body")
    finally:
        close_server(server)
