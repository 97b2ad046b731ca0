# SPDX-License-Identifier: Apache-2.0
"""What keeps a skin from being shown to other programs."""

from robotskin.errors import RobotskinError


class SharingError(RobotskinError):
    """A port that is taken, a library that is not there, a robot that is not known; the message says what to do."""
