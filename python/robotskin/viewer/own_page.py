# SPDX-License-Identifier: Apache-2.0
"""What the page is called and how it is set: put into the head of what the web server sends."""

from __future__ import annotations

import gzip
from collections.abc import Callable
from html import escape
from typing import Any

from websockets.datastructures import Headers
from websockets.http11 import Response

TITLE = "<title>Viser</title>"

# The names of controls are read, not guessed: no squeezed letters, no grey on grey. On a telephone the controls are a
# sheet as wide as the screen that leaves the robot its upper half.
STYLE = """
.mantine-Text-root:has(> label) {
  letter-spacing: normal !important; font-size: 0.84em !important; line-height: 1.2em !important;
  overflow-wrap: break-word !important; color: #d5dae1 !important;
}
@media (max-width: 36em) {
  [style*="width: 20em"] { width: 100% !important; }
  [style*="max-height: 60%"] { max-height: 46% !important; }
}
"""

NO_SCENE = """
canvas { display: none !important; }
[style*="bottom: 0px; right: 0px; width:"], [style*="flex-direction: row; position: relative; width:"] {
  width: 100% !important;
}
[style*="max-height: 60%"] { max-height: 100% !important; top: 0; }
.mantine-Notifications-root { top: auto !important; bottom: 16px !important; }
"""
"""Of a page that shows nothing but controls: they take all of it."""

Answer = Callable[[Any, Any], Response | None]


def with_own_head(answer: Answer, title: str, style: str = "") -> Answer:
    """What answers requests, changed so that pages bear this title and this style; all else stays as it is."""
    head = f"<title>{escape(title)} · robotskin</title><style>{STYLE}{style}</style>".encode()
    made: dict[bytes, bytes] = {}

    def own(connection: Any, request: Any) -> Response | None:
        response = answer(connection, request)
        if response is None or "text/html" not in response.headers.get("Content-Type", ""):
            return response
        body = bytes(response.body or b"")
        if body not in made:
            packed = response.headers.get("Content-Encoding") == "gzip"
            page = (gzip.decompress(body) if packed else body).replace(TITLE.encode(), head, 1)
            made.clear()
            made[body] = gzip.compress(page) if packed else page
        headers = Headers(response.headers.raw_items())
        del headers["Content-Length"]
        headers["Content-Length"] = str(len(made[body]))
        return Response(response.status_code, response.reason_phrase, headers, made[body])

    return own
