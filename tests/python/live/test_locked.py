# SPDX-License-Identifier: Apache-2.0
"""A robot that was locked from elsewhere says why on its page, and starts again by its page alone."""

import time
from collections.abc import Callable

from robotskin import layout, robots
from robotskin.live.live_session import LiveSession
from robotskin.session import Session

ROBOT = "allegro_right_hand"
PATIENCE_S = 180.0


def until(true: Callable[[], bool]) -> None:
    ends = time.monotonic() + PATIENCE_S
    while not true():
        assert time.monotonic() < ends
        time.sleep(0.02)


def test_only_its_page_starts_it_again(seed: int) -> None:
    session = Session(robots.load(ROBOT), layout.finished(ROBOT), seed=seed)
    session.boot()
    with LiveSession(session) as live:
        until(lambda: live.snapshot().controller_state == "running")
        session.lock("stopped by desk")
        until(lambda: live.snapshot().controller_state == "ready")
        assert live.snapshot().stop_reason == "stopped by desk"
        session.start()
        time.sleep(0.2)
        assert live.snapshot().controller_state == "ready"
        live.reset()
        until(lambda: live.snapshot().controller_state == "running")
        assert live.snapshot().stop_reason == ""
