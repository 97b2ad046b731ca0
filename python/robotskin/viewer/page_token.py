# SPDX-License-Identifier: Apache-2.0
"""The secret in a page's address: a server answers only browsers and programs that have it."""

from __future__ import annotations

import hmac
import re
import secrets
from http import HTTPStatus
from typing import Any
from urllib.parse import parse_qs, urlsplit

from websockets.datastructures import Headers
from websockets.http11 import Response

from robotskin.viewer.own_page import Answer

REFUSED = (
    "This page needs the token of its address. The right address stands in the terminal where robotskin was started: "
    "http://127.0.0.1:PORT/?token=…\n"
)
HOST_PORT = re.compile(r":(\d+)$")
TOKEN_BYTES = 16


def fresh_token() -> str:
    """22 characters that stand in a URL as they are."""
    return secrets.token_urlsafe(TOKEN_BYTES)


def for_holders_only(answer: Answer | None, token: str) -> Answer:
    """What answers requests, changed so that all of them need the token: in the address, or in a cookie.

    The page's address has it, and its first answer sets the cookie, with which the browser asks for files and opens
    the WebSocket. All else is refused with 403 and a sentence that says where the right address stands.
    """

    def checked(connection: Any, request: Any) -> Response | None:
        cookie = cookie_name(request.headers)
        by_address = any(_same(one, token) for one in parse_qs(urlsplit(request.path).query).get("token", ()))
        if not (by_address or any(_same(one, token) for one in _cookies(request.headers, cookie))):
            refusal: Response = connection.respond(HTTPStatus.FORBIDDEN, REFUSED)
            refusal.headers["Cache-Control"] = "no-store"
            return refusal
        response = None if answer is None else answer(connection, request)
        if response is not None:
            response.headers["Referrer-Policy"] = "no-referrer"
            if by_address:
                response.headers["Set-Cookie"] = f"{cookie}={token}; Path=/; HttpOnly; SameSite=Strict"
        return response

    return checked


def cookie_name(headers: Headers) -> str:
    """Of a request: it tells the port, because cookies of all ports of a machine lie together in a browser.

    It is the browser's port, which another may stand in for (ssh -L).
    """
    found = HOST_PORT.search(headers.get("Host", ""))
    return f"robotskin_page_{found.group(1) if found else '80'}"


def _cookies(headers: Headers, name: str) -> list[str]:
    parts = (part.strip().partition("=") for line in headers.get_all("Cookie") for part in line.split(";"))
    return [value for found, _, value in parts if found == name]


def _same(given: str, token: str) -> bool:
    return hmac.compare_digest(given.encode(errors="replace"), token.encode())
