# SPDX-License-Identifier: Apache-2.0
"""Tapes: what driver and skin reader did, entry by entry, and back to the byte."""

from robotskin._core.record import *  # noqa: F403
