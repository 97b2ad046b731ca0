# SPDX-License-Identifier: Apache-2.0
"""Stages 1 to 3 as they are compiled: wire and datagram format, channels, times, and the firmware's arithmetic."""

from robotskin._core.firmware import *  # noqa: F403
