# SPDX-License-Identifier: Apache-2.0
"""What can go wrong with the firmware on a chip."""

from robotskin.errors import RobotskinError


class ChipError(RobotskinError):
    """The firmware cannot be built for the chip, or does not run there; the message says what is missing or where."""
