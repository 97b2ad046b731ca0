# SPDX-License-Identifier: Apache-2.0
"""What is wrong with a calibration or with the presses that it is made from."""

from robotskin.errors import RobotskinError


class CalibrationError(RobotskinError):
    """A calibration of another skin, a damaged file, or presses that cannot be used; the message says which and why."""
