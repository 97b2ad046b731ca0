# SPDX-License-Identifier: Apache-2.0
"""Why another maker's skin cannot be read."""

from robotskin.errors import RobotskinError


class ForeignSkinError(RobotskinError):
    """A declaration or a stream that does not fit; the message names file, field, value and what would be valid."""
