# SPDX-License-Identifier: Apache-2.0
"""What can be recorded, and what a recording says of it beside its messages."""

from __future__ import annotations

import json
import time
from typing import Protocol

import robotskin
from robotskin.driver import Driver
from robotskin.layout import Layout
from robotskin.layout.json_file import to_text
from robotskin.loop import SkinLoop
from robotskin.robots.gains.gain_file import written
from robotskin.skin import SkinReader

FORMAT_VERSION = 1
GAINS = "gains.toml"


class Recorded(Protocol):
    """What can be recorded: a running skin with its driver and reader, or one without, in a loop."""

    @property
    def layout(self) -> Layout:
        """Of the skin."""

    @property
    def driver(self) -> Driver | None:
        """None: another maker's skin."""

    @property
    def reader(self) -> SkinReader | None:
        """None: another maker's skin."""

    @property
    def loop(self) -> SkinLoop | None:
        """Whose joints and commands are recorded; None: no robot."""


def attachments_of(session: Recorded) -> dict[str, str]:
    """What a recording holds beside its messages, by the names of files: layout, calibration, robot, gains."""
    found = {"layout.json": to_text(session.layout)}
    if session.layout.calibration is not None:
        found["calibration.json"] = session.layout.calibration.to_text()
    robot = getattr(session, "robot", None)
    if robot is not None:
        found["robot.urdf"] = robot.urdf
    gains = getattr(session, "gains", None)
    if gains is not None:
        found[GAINS] = written(gains.values, [f"Gains of {gains.robot}, as they were while it was recorded."])
    return found


def about_of(session: Recorded) -> dict[str, str]:
    """Facts of a run: robot, cells, versions, seed, and what it did at the beginning."""
    facts = {
        "format_version": str(FORMAT_VERSION),
        "robotskin": robotskin.__version__,
        "cells": str(len(session.layout)),
        "robot": session.layout.robot,
        "clock": "host, nanoseconds; of the simulated world where there is one",
        "started": time.strftime("%Y-%m-%dT%H:%M:%SZ", time.gmtime()),
    }
    for name in ("seed", "interface", "mode", "behaviour"):
        if hasattr(session, name):
            facts[name] = str(getattr(session, name))
    if session.loop is not None:
        facts["sensors"] = " ".join(session.loop.skin.sensors)
    robot = getattr(session, "robot", None)
    if robot is not None:
        facts["joints"] = json.dumps(list(robot.joint_names))
    return facts
