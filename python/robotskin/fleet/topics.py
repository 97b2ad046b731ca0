# SPDX-License-Identifier: Apache-2.0
"""Under which keys of Zenoh a fleet speaks: the one home of their names.

A robot speaks under its own prefix alone, and only what monitors say stands under `robotskin/stop`.
"""

from __future__ import annotations

ABOUT = "about"
"""Asked for by late joiners: layout, robot, calibration."""
TAPE = "tape"
"""All that driver and controller do, from which the skin state comes back to the byte."""
EVENTS = "events"
"""Samples that cells in event mode sent for a change, decoded."""
STATE = "state"
"""Some times a second: what the robot does, its skin's health, its contacts."""
ALIVE = "alive"
"""A liveliness token."""


def of_robot(name: str, what: str) -> str:
    """The key of what a robot says; `*` for all robots."""
    return f"robotskin/robot/{name}/{what}"


def under(name: str) -> list[str]:
    """All that a robot says, and the caches of it, which a wildcard does not take in; `*` for all robots."""
    prefix = f"robotskin/robot/{name}"
    return [f"{prefix}/**", f"{prefix}/**/@adv/**"]


def stop_of(name: str) -> str:
    """Where monitors tell a robot to stop; `*` for all."""
    return f"robotskin/stop/{name}"


def robot_of(key: str) -> str:
    """The robot that speaks under a key of `of_robot`; empty for any other key."""
    parts = key.split("/")
    return parts[2] if len(parts) > 3 and parts[:2] == ["robotskin", "robot"] else ""
