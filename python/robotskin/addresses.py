# SPDX-License-Identifier: Apache-2.0
"""Addresses of section units and hosts as texts, without anything that a small machine would have to load."""

from __future__ import annotations

from robotskin.errors import InputError


def host_and_port(text: str) -> tuple[str, int]:
    """HOST:PORT. Raises InputError for what is none."""
    host, _, port = text.rpartition(":")
    if not host or not port.isdigit() or not 0 < int(port) < 65536:
        raise InputError(f"section unit {text!r}: give HOST:PORT, such as 192.168.1.30:21100")
    return host.strip("[]"), int(port)
