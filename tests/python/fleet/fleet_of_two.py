# SPDX-License-Identifier: Apache-2.0
"""A router and the files of its members, for tests."""

import socket
import time
from collections.abc import Callable
from pathlib import Path

import msgspec

from robotskin.fleet import Member
from robotskin.fleet.authority import make_keys
from robotskin.fleet.link import open_router

PATIENCE_S = 180.0


class FleetOfTwo:
    """Robots left and right, the monitor desk, the follower screen."""

    def __init__(self, folder: Path) -> None:
        self.folder = folder
        self.port = free_port()
        make_keys(folder, ["left", "right"], ["desk"], ["screen"], f"127.0.0.1:{self.port}")
        self.router = open_router(self.member("router"))

    def member(self, name: str, port: int | None = None) -> Member:
        """By its file; through a relay at another port where one is told."""
        found = Member.load(self.folder / f"{name}.fleet")
        return found if port is None else msgspec.structs.replace(found, router=f"127.0.0.1:{port}")

    def close(self) -> None:
        self.router.close()


def free_port() -> int:
    with socket.create_server(("127.0.0.1", 0)) as listener:
        return int(listener.getsockname()[1])


def until(true: Callable[[], object], again: Callable[[], object] = lambda: None) -> None:
    """Wait, repeating an action, until something is true."""
    ends = time.monotonic() + PATIENCE_S
    while not true():
        assert time.monotonic() < ends, "never became true"
        again()
        time.sleep(0.02)
