# SPDX-License-Identifier: Apache-2.0
"""What keeps this program from a Franka robot."""

from robotskin.errors import RobotskinError


class FrankaError(RobotskinError):
    """A robot or library that is not there, or is another one; the message says what was found and expected."""
