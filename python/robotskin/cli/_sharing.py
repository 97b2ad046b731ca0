# SPDX-License-Identifier: Apache-2.0
"""The options that show a running skin to other programs, of every verb that runs one."""

from __future__ import annotations

import contextlib
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

if TYPE_CHECKING:
    from robotskin.record import Recorder
    from robotskin.record.recorder import Recorded
    from robotskin.robots import Robot
    from robotskin.sharing.follower import Show

Foxglove = Annotated[
    int | None,
    typer.Option(
        "--foxglove",
        metavar="[PORT]",
        help="Let Foxglove look on, on 127.0.0.1 (docs/seen_by_others.md); 8765 unless told, 0: any free port.",
        max=65535,
        min=0,
    ),
]


def shared(
    session: Recorded, robot: Robot, record: Path | None, foxglove: int | None
) -> contextlib.AbstractContextManager[Recorder | None]:
    """The session recorded and shown where options ask for it, while a `with` block lasts."""
    from robotskin.sharing.shared import shared as shared_session

    shows: list[Show] = []
    if foxglove is not None:
        from robotskin.sharing.foxglove_server import FoxgloveServer

        server = FoxgloveServer(robot, session.layout, foxglove)
        tell(server.told)
        shows.append(server)
    return shared_session(session, shows, record, tell)


def tell(text: str) -> None:
    """Print a line that may hold a path."""
    from rich.console import Console

    Console().print(text, markup=False, highlight=False, soft_wrap=True)
