# SPDX-License-Identifier: Apache-2.0
"""What keeps a recording from being exported."""

from robotskin.errors import RobotskinError


class ExportFormatError(RobotskinError):
    """A recording that cannot be exported, or a place that cannot be written; the message says what to do."""
