# SPDX-License-Identifier: Apache-2.0
"""Errors of the layout package: each names the thing, its value and what would be right."""

from robotskin.errors import RobotskinError


class LayoutError(RobotskinError):
    """Arrays or requests that make no skin layout."""


class LayoutFileError(LayoutError):
    """A file that cannot be read as a layout.

    file: its path; field: where in it, as a JSON pointer, XML path or line; value: what stands there.
    """

    def __init__(self, file: object, field: str, value: object, why: str) -> None:
        self.file, self.field, self.value, self.why = str(file), field, value, why
        shown = repr(value)
        super().__init__(f"{file}: {field}: {shown if len(shown) < 80 else shown[:77] + '...'}: {why}")


class CoveringError(LayoutError):
    """A covering that cannot be made: unknown link, or fewer places than cells asked for."""
