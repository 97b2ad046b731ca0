# SPDX-License-Identifier: Apache-2.0
"""What keeps a robot out of its fleet."""

from robotskin.errors import RobotskinError


class FleetError(RobotskinError):
    """A file that is none, a router that is not reached, a robot that does not answer; the message says what to do."""
