# SPDX-License-Identifier: Apache-2.0
"""Stage 7: tasks, the ways to fuse them, and the torque resolver. A task of your own is a `PythonTask`."""

from robotskin._core.control import *  # noqa: F403
