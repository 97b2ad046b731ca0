# SPDX-License-Identifier: Apache-2.0
"""The loop that runs on a robot, from samples to command or stop, over a `SkinInput` and a `RobotPort`."""

from robotskin._core.loop import *  # noqa: F403
