# SPDX-License-Identifier: Apache-2.0
"""The page's server is reached from this machine's own pages alone."""

from collections.abc import Iterator

import pytest
import viser
import websockets.asyncio.server
from websockets.exceptions import InvalidStatus
from websockets.sync.client import connect

from robotskin.viewer.server import close_server, open_server


@pytest.fixture
def server() -> Iterator[viser.ViserServer]:
    server = open_server("a page", 8080)
    yield server
    close_server(server)


@pytest.mark.parametrize(
    "origin", ["http://example.com", "https://127.0.0.1.example.com", "http://localhost.example.com:8080", "null"]
)
def test_a_page_of_another_origin_is_refused(server: viser.ViserServer, origin: str) -> None:
    with (
        pytest.raises(InvalidStatus, match="403"),
        connect(f"ws://127.0.0.1:{server.get_port()}", origin=origin),  # type: ignore[arg-type]
    ):
        pass
    assert not server.get_clients()


@pytest.mark.parametrize("origin", ["http://127.0.0.1:8080", "http://localhost:9000", None])
def test_own_pages_and_other_programs_are_let_in(server: viser.ViserServer, origin: str | None) -> None:
    with connect(f"ws://127.0.0.1:{server.get_port()}", origin=origin) as socket:  # type: ignore[arg-type]
        assert socket.response is not None
        assert socket.response.status_code == 101


def test_starting_a_server_changes_nothing_for_others() -> None:
    before = websockets.asyncio.server.serve
    close_server(open_server("a page", 8080))
    assert websockets.asyncio.server.serve is before
