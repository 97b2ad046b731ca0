# SPDX-License-Identifier: Apache-2.0
"""What keeps this program from topics of ROS 2, or a robot from being moved by them."""

from robotskin.errors import RobotskinError


class Ros2Error(RobotskinError):
    """A domain, interface, topic, joint or library that is not there; the message says what was found and expected."""
