# SPDX-License-Identifier: Apache-2.0
"""Stages 7 and 8 in one tick: the task cycle, the guard with its limits and states, the limits of contact."""

from robotskin._core.robot import *  # noqa: F403
