# SPDX-License-Identifier: Apache-2.0
"""Evidence of the health of cells: what their channels did during a window of time, and what they should have felt."""

from robotskin._core.health import *  # noqa: F403
