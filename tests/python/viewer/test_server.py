# SPDX-License-Identifier: Apache-2.0
"""The page's server is reached from this machine's own pages alone, and by those that have the token of its address."""

import urllib.error
import urllib.request
from collections.abc import Iterator
from http.client import HTTPMessage

import pytest
import websockets.asyncio.server
from websockets.exceptions import InvalidStatus
from websockets.sync.client import connect

from robotskin.viewer.page_token import fresh_token
from robotskin.viewer.server import PageServer, address, close_server, open_server

COOKIES_OF_OTHERS = 'theme="a b"; odd{}=1; _xsrf=2|7; '


@pytest.fixture
def server() -> Iterator[PageServer]:
    server = open_server("a page", 8080)
    yield server
    close_server(server)


@pytest.fixture
def other_server() -> Iterator[PageServer]:
    server = open_server("another page", 8080)
    yield server
    close_server(server)


def bare(server: PageServer) -> str:
    return f"127.0.0.1:{server.get_port()}"


def asked(url: str, **headers: str) -> tuple[int, HTTPMessage, str]:
    """Status, headers and text of what is answered."""
    try:
        with urllib.request.urlopen(urllib.request.Request(url, headers=headers)) as answer:
            return answer.status, answer.headers, answer.read().decode(errors="replace")
    except urllib.error.HTTPError as refusal:
        return refusal.code, refusal.headers, refusal.read().decode()


def refused(url: str, **headers: str) -> bool:
    """Whether both the page and its WebSocket are refused, with a sentence that says where the right address is."""
    status, _, told = asked(url, **headers)
    try:
        with connect(url.replace("http:", "ws:"), additional_headers=headers):
            return False
    except InvalidStatus as refusal:
        said = bytes(refusal.response.body or b"").decode()
        codes = {status, refusal.response.status_code}
        return codes == {403} and "terminal" in told and "?token=" in told and said == told


def cookie_of(server: PageServer) -> str:
    """What the page's first answer makes a browser send from then on."""
    _, headers, _ = asked(address(server))
    return str(headers["Set-Cookie"]).partition(";")[0]


def test_the_address_opens_page_and_socket(server: PageServer) -> None:
    status, _, page = asked(address(server))
    assert status == 200
    assert "<title>a page" in page
    with connect(address(server).replace("http:", "ws:")) as socket:
        assert socket.response is not None
        assert socket.response.status_code == 101


def test_the_first_answer_sets_a_cookie_that_opens_all_else(server: PageServer) -> None:
    _, headers, _ = asked(address(server))
    pair, *flags = str(headers["Set-Cookie"]).split("; ")
    assert str(server.get_port()) in pair.partition("=")[0]
    assert {"HttpOnly", "SameSite=Strict"} <= set(flags)
    assert headers["Referrer-Policy"] == "no-referrer"
    for cookie in (pair, COOKIES_OF_OTHERS + pair):
        assert asked(f"http://{bare(server)}/", Cookie=cookie)[0] == 200
        with connect(f"ws://{bare(server)}", additional_headers={"Cookie": cookie}) as socket:
            assert socket.response is not None
            assert socket.response.status_code == 101


def test_behind_another_port_the_cookie_is_that_port_s(server: PageServer) -> None:
    _, headers, _ = asked(address(server), Host="localhost:9000")
    pair = str(headers["Set-Cookie"]).partition(";")[0]
    assert "9000" in pair.partition("=")[0]
    assert asked(f"http://{bare(server)}/", Host="localhost:9000", Cookie=pair)[0] == 200


@pytest.mark.parametrize("path", ["/", "/index.html", "/no_such_file", "/?token=", "/?tokens=1"])
def test_without_a_token_nothing_is_answered(server: PageServer, path: str) -> None:
    assert refused(f"http://{bare(server)}{path}")
    assert not server.get_clients()


def test_wrong_tokens_are_refused(server: PageServer) -> None:
    right = server.token
    for wrong in (fresh_token(), right[:-1], right + "A", right.swapcase(), "%C3%A9", "%ff"):
        assert refused(f"http://{bare(server)}/?token={wrong}"), wrong
        name = cookie_of(server).partition("=")[0]
        assert refused(f"http://{bare(server)}/", Cookie=f"{name}={wrong}"), wrong


def test_what_opens_one_page_does_not_open_another(server: PageServer, other_server: PageServer) -> None:
    own, other = cookie_of(server), cookie_of(other_server)
    assert own != other
    assert refused(f"http://{bare(server)}/", Cookie=other)
    value = other.partition("=")[2]
    assert refused(f"http://{bare(server)}/", Cookie=f"{own.partition('=')[0]}={value}")
    assert refused(f"http://{bare(server)}/?token={other_server.token}")
    assert asked(f"http://{bare(server)}/", Cookie=f"{other}; {own}")[0] == 200


@pytest.mark.parametrize(
    "origin", ["http://example.com", "https://127.0.0.1.example.com", "http://localhost.example.com:8080", "null"]
)
def test_a_page_of_another_origin_is_refused_even_with_the_token(server: PageServer, origin: str) -> None:
    with (
        pytest.raises(InvalidStatus, match="403"),
        connect(address(server).replace("http:", "ws:"), origin=origin),  # type: ignore[arg-type]
    ):
        pass
    assert not server.get_clients()


@pytest.mark.parametrize("origin", ["http://127.0.0.1:8080", "http://localhost:9000", None])
def test_own_pages_and_other_programs_are_let_in_with_the_token(server: PageServer, origin: str | None) -> None:
    with connect(address(server).replace("http:", "ws:"), origin=origin) as socket:  # type: ignore[arg-type]
        assert socket.response is not None
        assert socket.response.status_code == 101


def test_starting_a_server_changes_nothing_for_others() -> None:
    before = websockets.asyncio.server.serve
    close_server(open_server("a page", 8080))
    assert websockets.asyncio.server.serve is before
