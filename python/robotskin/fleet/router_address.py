# SPDX-License-Identifier: Apache-2.0
"""Where a fleet's router is."""

from __future__ import annotations

from robotskin.fleet.errors import FleetError

PORT = 7447
"""Zenoh's own."""


def router_address(text: str) -> tuple[str, int]:
    """HOST:PORT. Raises FleetError for what is none."""
    host, _, port = text.rpartition(":")
    host = host.strip("[]")
    if not host or not host.isascii() or not host.isprintable() or set(host) & set("/#?; ") or not port.isdigit():
        raise FleetError(f"fleet router {text[:80]!r}: give HOST:PORT, such as 192.168.1.10:{PORT}")
    if not 0 < int(port) < 65536:
        raise FleetError(f"fleet router {text[:80]!r}: port {port}: 1 to 65535")
    return host, int(port)


def endpoint(text: str) -> str:
    """The address as Zenoh writes it. Raises FleetError."""
    host, port = router_address(text)
    return f"tls/{f'[{host}]' if ':' in host else host}:{port}"
