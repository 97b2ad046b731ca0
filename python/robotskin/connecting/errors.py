# SPDX-License-Identifier: Apache-2.0
"""Why a robot and a skin are not run together."""

from robotskin.errors import RobotskinError


class ConnectError(RobotskinError):
    """A skin or a robot that is not the one expected; the message says what was found and what was expected."""
