# SPDX-License-Identifier: Apache-2.0
"""What a skin feels, for other programs: while it runs, or out of a recording."""

from robotskin.sharing.errors import SharingError

FOXGLOVE_PORT = 8765
"""Where Foxglove looks first."""
ROS2_DOMAIN = 0
"""The domain of DDS that ROS 2 takes unless told otherwise."""

__all__ = ["FOXGLOVE_PORT", "ROS2_DOMAIN", "SharingError"]
