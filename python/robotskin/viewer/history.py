# SPDX-License-Identifier: Apache-2.0
"""What was done to a layout, step by step, to be undone and done again."""

from __future__ import annotations

from robotskin.layout import Layout

MOST_STEPS = 200
"""Steps kept; a step is a layout, some hundred kilobytes for a thousand cells."""


class History:
    """The layout as it now is, those before it and those undone."""

    def __init__(self, layout: Layout) -> None:
        self.layout = layout
        self._saved = layout
        self._past: list[Layout] = []
        self._future: list[Layout] = []

    @property
    def undoable(self) -> int:
        """Steps that can be undone."""
        return len(self._past)

    @property
    def redoable(self) -> int:
        """Steps that can be done again."""
        return len(self._future)

    @property
    def unsaved(self) -> bool:
        """Whether the layout differs from the last one saved."""
        return self.layout is not self._saved

    def do(self, layout: Layout) -> None:
        """Take one step; what was undone is forgotten."""
        self._past = [*self._past, self.layout][-MOST_STEPS:]
        self._future = []
        self.layout = layout

    def undo(self) -> bool:
        """Back by one step; False if there is none."""
        if not self._past:
            return False
        self._future.append(self.layout)
        self.layout = self._past.pop()
        return True

    def redo(self) -> bool:
        """Forward by one step; False if there is none."""
        if not self._future:
            return False
        self._past.append(self.layout)
        self.layout = self._future.pop()
        return True

    def mark_saved(self) -> None:
        """The layout as it now is has been saved."""
        self._saved = self.layout
