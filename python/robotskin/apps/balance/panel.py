# SPDX-License-Identifier: Apache-2.0
"""The standing robot in the browser."""

from __future__ import annotations

import threading

from rich.console import Console

from robotskin.live.live_session import LiveSession
from robotskin.session import Session
from robotskin.viewer.page import Page


def show(session: Session, port: int) -> None:
    """Serve the page until it is interrupted; then bring the robot to rest."""
    console = Console()
    try:
        with console.status("booting the skin"):
            session.boot()
    except BaseException:
        session.shut_down()
        raise
    with LiveSession(session) as live, Page(live, port) as page:
        console.print(f"open [bold]{page.address}[/] and push the robot (Ctrl-C ends)")
        try:
            threading.Event().wait()
        except KeyboardInterrupt:
            console.print("bringing the robot to rest")
