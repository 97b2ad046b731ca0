# SPDX-License-Identifier: Apache-2.0
"""Why a Franka robot takes commands, or does not."""

from __future__ import annotations

import enum


class FrankaCondition(enum.IntEnum):
    """Of the robot behind a port."""

    ready = 0
    disconnected = 1
    reflex = 2
    user_stop = 3
    guiding = 4
    busy = 5


TOLD = {
    FrankaCondition.ready: "",
    FrankaCondition.disconnected: "the controller does not answer",
    FrankaCondition.reflex: "the controller stopped it by a reflex: see what it touches, then start anew",
    FrankaCondition.user_stop: "user stop: release the enabling device",
    FrankaCondition.guiding: "it is guided by hand",
    FrankaCondition.busy: "it does something else: see its Desk",
}
"""In words that say what to do."""

MODES = {
    "Idle": FrankaCondition.ready,
    "Move": FrankaCondition.ready,
    "Reflex": FrankaCondition.reflex,
    "UserStopped": FrankaCondition.user_stop,
    "Guiding": FrankaCondition.guiding,
}
"""By the name of the robot mode in libfranka; every other one is `busy`."""


def condition_of(mode: str) -> FrankaCondition:
    """Of a robot mode by its name."""
    return MODES.get(mode, FrankaCondition.busy)
