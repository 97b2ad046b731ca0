# SPDX-License-Identifier: Apache-2.0
"""Robots of tests that run in real time, on machines that may be busy."""

import time
from collections.abc import Callable

from robotskin.connecting import ConnectedRobot
from robotskin.cycle import SafetyState


def runs_until(session: ConnectedRobot, holds: Callable[[], bool], within_s: float = 25.0) -> bool:
    """Runs on. A busy machine makes the skin stale now and then: then the robot is started anew, as a person would."""
    ends = time.monotonic() + within_s
    while time.monotonic() < ends:
        session.run(0.05)
        if holds():
            return True
        if session.state is SafetyState.stopped:
            session.stop()
        elif session.state is SafetyState.ready:
            session.start()
            session.controller.request_goal(session.home)  # where it stopped is where it would stay
    return False
